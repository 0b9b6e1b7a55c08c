// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ: v and f lines. Everything else is counted and told.
#include <array>
#include <map>

#include "base/text.hpp"
#include "formats/line_words.hpp"
#include "formats/mesh_builder.hpp"
#include "formats/text_columns.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kMaxJoined = 16 * kMaxLine;  // a line with all its continuations
constexpr std::string_view kPatchGroup = "patch_";

class ObjReader {
 public:
  explicit ObjReader(const ByteSource& source) : source_(source), lines_(source), builder_(source.name()) {}

  Result<MeshFile> read() {
    builder_.mesh.format = "obj";
    while (!lines_.at_end()) {
      TRY_ASSIGN(const std::string_view line, next_line());
      TRY(take(line));
    }
    if (builder_.vertex_count() == 0)
      return fail(Code::BadInput, "the file holds no line \"v x y z\"; wanted vertices and faces", source_.name());
    tell_skipped();
    if (patch_known_ && !builder_.mesh.triangles.empty()) builder_.mesh.patch = std::move(patch_);
    return builder_.finish();
  }

 private:
  /// A line with those it goes on in: a backslash before its end.
  Result<std::string_view> next_line() {
    TRY_ASSIGN(std::string_view line, lines_.next());
    first_line_ = lines_.number();
    if (!continues(line)) return line;
    joined_.clear();
    while (continues(line)) {
      joined_.append(line.substr(0, line.find_last_of('\\')));
      joined_ += ' ';
      if (joined_.size() > kMaxJoined)
        return fail(Code::BadInput, "a line with its continuations is longer than 16 MiB", place());
      if (lines_.at_end()) return std::string_view(joined_);
      TRY_ASSIGN(line, lines_.next());
    }
    joined_.append(line);
    return std::string_view(joined_);
  }
  static bool continues(std::string_view line) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
    return !line.empty() && line.back() == '\\';
  }

  std::string place() const { return line_place(source_.name(), first_line_); }

  Result<void> take(std::string_view line) {
    LineWords words(line);
    const std::string_view word = words.next();
    if (word.empty()) return {};
    if (has_carriage_return_inside(line))
      return fail(Code::BadInput, "the lines end in a carriage return alone; convert the line ends", place());
    if (word == "v") return take_vertex(words, line);
    if (word == "f" || word == "fo") return take_face(words, line);
    if (word[0] == '#') {
      builder_.add_comment(line.substr(line.find('#') + 1));
    } else if (word == "g") {
      take_group(words.rest());
    } else {
      ++skipped_[std::string(word.substr(0, 20))];
    }
    return {};
  }

  Result<void> take_vertex(LineWords& words, std::string_view line) {
    Vec3 p;
    if (!(words.number(p.x) && words.number(p.y) && words.number(p.z)))
      return fail(Code::BadInput, "found " + quoted(line) + ", wanted \"v x y z\" with three numbers", place());
    double more = 0;
    int extra = 0;
    while (words.number(more)) ++extra;
    if (!words.at_end())
      return fail(Code::BadInput, "found " + quoted(words.next()) + " behind a vertex, wanted numbers", place());
    weights_ += extra == 1;
    colours_ += extra > 1;
    return builder_.add_vertex(p);
  }

  Result<void> take_face(LineWords& words, std::string_view line) {
    corners_.clear();
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      if (word[0] == '#') break;
      std::int64_t index = 0;
      const std::size_t length = std::min(word.find('/'), word.size());
      const auto [end, error] = std::from_chars(word.data(), word.data() + length, index);
      if (error != std::errc{} || end != word.data() + length || index == 0)
        return fail(Code::BadInput,
                    "found " + quoted(word) + " in " + quoted(line) +
                        ", wanted a vertex number: 1 and up from the first, -1 and down from the last",
                    place());
      const auto have = static_cast<std::int64_t>(builder_.vertex_count());
      if (index < -have)
        return fail(Code::BadInput,
                    "a face names vertex " + std::to_string(index) + ", but only " + grouped(builder_.vertex_count()) +
                        " vertices stand before it",
                    place());
      corners_.push_back(static_cast<std::uint64_t>(index > 0 ? index - 1 : have + index));
    }
    builder_.add_polygon(corners_, {true, first_line_});
    // Patches only where every face lies in a group of ours.
    patch_known_ &= in_patch_ || corners_.size() < 3;
    if (patch_known_) patch_.resize(builder_.mesh.triangles.size(), current_patch_);
    return {};
  }

  void take_group(std::string_view name) {
    in_patch_ = false;
    if (name.substr(0, kPatchGroup.size()) == kPatchGroup) {
      const std::string_view number = name.substr(kPatchGroup.size());
      const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), current_patch_);
      in_patch_ = error == std::errc{} && end == number.data() + number.size();
    }
    other_groups_ += !in_patch_;
  }

  void tell_skipped() {
    static const std::map<std::string_view, const char*> kMeaning = {{"vt", "texture coordinates"},
                                                                     {"vn", "normals"},
                                                                     {"vp", "parameter points"},
                                                                     {"usemtl", "uses of materials"},
                                                                     {"mtllib", "material libraries"},
                                                                     {"s", "smoothing groups"},
                                                                     {"o", "object names"},
                                                                     {"l", "lines"},
                                                                     {"p", "points"}};
    if (colours_ > 0) builder_.skipped(grouped(colours_) + " vertex colours");
    if (weights_ > 0) builder_.skipped(grouped(weights_) + " vertex weights");
    if (other_groups_ > 0) builder_.skipped(grouped(other_groups_) + " group names");
    for (const auto& [word, count] : skipped_) {
      const auto meaning = kMeaning.find(word);
      builder_.skipped(grouped(count) +
                       (meaning != kMeaning.end() ? " " + std::string(meaning->second) + " (" : " lines (") +
                       quoted(word) + ")");
    }
  }

  const ByteSource& source_;
  NumberedLines lines_;
  MeshBuilder builder_;
  std::string joined_;
  std::uint64_t first_line_ = 0;
  std::vector<std::uint64_t> corners_;
  std::vector<std::uint32_t> patch_;
  std::uint32_t current_patch_ = 0;
  bool in_patch_ = false, patch_known_ = true;
  std::uint64_t weights_ = 0, colours_ = 0, other_groups_ = 0;
  std::map<std::string, std::uint64_t> skipped_;
};

}  // namespace

Result<MeshFile> read_obj_mesh(const ByteSource& source) { return ObjReader(source).read(); }

}  // namespace scanmill::formats
