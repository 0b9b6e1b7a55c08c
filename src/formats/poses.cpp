// SPDX-License-Identifier: Apache-2.0
#include "formats/poses.hpp"

#include <array>
#include <cmath>
#include <optional>

#include "base/text.hpp"
#include "formats/conf.hpp"
#include "formats/cursor.hpp"
#include "formats/text_columns.hpp"

namespace scanmill::formats {
namespace {

constexpr std::uint64_t kMaxPoses = 256 << 20;

class PosePass {
 public:
  explicit PosePass(const ByteSource& source) : source_(source), cursor_(source) {}

  Result<std::vector<NamedPose>> run() {
    TRY(next());
    if (at_end_) return fail(Code::BadInput, "the file holds no pose, wanted 4x4 matrices", source_.name());
    if (numbers_.size() == 1) return read_aln();
    std::vector<NamedPose> poses;
    const bool has_heads = numbers_.size() == 3;
    while (!at_end_) {
      if (has_heads) TRY(pass_head());
      NamedPose& pose = poses.emplace_back();
      TRY_ASSIGN(pose.pose, matrix());
    }
    return poses;
  }

 private:
  Error wanted(const std::string& what) const {
    if (at_end_)
      return fail(Code::BadInput, "the file ends, wanted " + what + "; it was cut", line_place(source_.name(), line_));
    return fail(Code::BadInput, "found " + quoted(text_) + ", wanted " + what, line_place(source_.name(), line_));
  }

  /// The next line that says something; its numbers, none where a word is not one.
  Result<void> next() {
    numbers_.clear();
    for (;;) {
      ++line_;
      at_end_ = cursor_.at_end();
      if (at_end_) return {};
      TRY_ASSIGN(const std::string_view line, cursor_.line());
      if (is_comment_or_blank(line)) continue;
      text_ = line;
      break;
    }
    for (const std::string_view word : columns_of(text_)) {
      const auto value = parse_number(word);
      if (!value || !std::isfinite(*value)) {
        numbers_.clear();
        return {};
      }
      numbers_.push_back(*value);
    }
    return {};
  }

  static bool is_whole(double value) { return value == std::floor(value) && std::abs(value) < 0x1p53; }

  Result<void> pass_head() {
    if (numbers_.size() != 3 || !is_whole(numbers_[0]) || !is_whole(numbers_[1]) || !is_whole(numbers_[2]))
      return wanted("three whole numbers before the matrix");
    return next();
  }

  /// Ends on the line behind the matrix.
  Result<Pose> matrix() {
    const std::uint64_t first = line_;
    std::array<double, 16> m{};
    for (std::size_t filled = 0; filled < 16;) {
      const bool good = !at_end_ && (numbers_.size() == 4 || (numbers_.size() == 16 && filled == 0));
      if (!good) return wanted("a row of four numbers of a 4x4 matrix");
      for (const double value : numbers_) m[filled++] = value;
      TRY(next());
    }
    auto pose = pose_from_matrix(m);
    if (!pose.ok()) return std::move(pose.error()).at(line_place(source_.name(), first));
    return pose;
  }

  Result<std::vector<NamedPose>> read_aln() {
    const double count = numbers_[0];
    if (!is_whole(count) || count < 1) return wanted("the number of meshes");
    std::vector<NamedPose> poses;
    TRY(next());
    while (!at_end_) {
      if (numbers_.size() == 1 && numbers_[0] == 0 && static_cast<double>(poses.size()) == count) break;
      NamedPose pose;
      pose.name = text_;
      while (!pose.name.empty() && (pose.name.back() == '\r' || pose.name.back() == ' ')) pose.name.pop_back();
      while (pose.name.starts_with("./")) pose.name.erase(0, 2);
      if (!is_inside(pose.name)) return wanted("the name of a mesh file inside the folder of the .aln");
      for (const NamedPose& other : poses)
        if (other.name == pose.name) return wanted("each mesh file once");
      TRY(next());
      TRY_ASSIGN(pose.pose, matrix());
      poses.push_back(std::move(pose));
    }
    if (static_cast<double>(poses.size()) != count)
      return fail(Code::BadInput,
                  "the first line declares " + number_text(count) + " meshes, the file holds " +
                      std::to_string(poses.size()) + "; it was cut or the count is wrong",
                  source_.name());
    return poses;
  }

  const ByteSource& source_;
  Cursor cursor_;
  std::uint64_t line_ = 0;
  bool at_end_ = false;
  std::string text_;
  std::vector<double> numbers_;
};

}  // namespace

Result<std::vector<NamedPose>> read_poses(const ByteSource& source) {
  if (source.size() > kMaxPoses)
    return fail(Code::BadInput, "the file is larger than 256 MiB; this is no list of poses", source.name());
  TRY_ASSIGN(const bool conf, is_conf(source));
  if (!conf) return PosePass(source).run();
  TRY_ASSIGN(const std::vector<ConfView> views, read_conf(source));
  std::vector<NamedPose> poses;
  for (const ConfView& view : views) poses.push_back({view.file, view.pose});
  return poses;
}

Result<Pose> read_3dtk_pose(const ByteSource& source) {
  if (source.size() > 4096)
    return fail(Code::BadInput, "the file is larger than 4 KiB; this is no pose", source.name());
  TRY_ASSIGN(const std::string text, read_all(source, 4096));
  std::array<double, 6> v{};
  std::size_t count = 0;
  const std::vector<std::string> lines = lines_of(text);
  for (std::size_t n = 0; n < lines.size(); ++n)
    for (const std::string_view word : words_of(lines[n])) {
      const auto value = parse_number(word);
      if (!value || !std::isfinite(*value) || count == 6)
        return fail(Code::BadInput, "found " + quoted(word) + ", wanted x y z and three angles in degrees",
                    line_place(source.name(), n + 1));
      v[count++] = *value;
    }
  if (count != 6)
    return fail(Code::BadInput, "found " + std::to_string(count) + " numbers, wanted x y z and three angles in degrees",
                source.name());
  Pose pose = pose_turned({1, 0, 0}, v[3]).after(pose_turned({0, 1, 0}, v[4])).after(pose_turned({0, 0, 1}, v[5]));
  for (const std::size_t at : {2u, 5u, 6u, 7u}) pose.rotation[at] = 0 - pose.rotation[at];
  pose.translation = {v[0], v[1], 0 - v[2]};
  return pose;
}

}  // namespace scanmill::formats
