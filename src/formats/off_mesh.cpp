// SPDX-License-Identifier: Apache-2.0
// OFF (Geomview): a keyword, three counts, a line per vertex and a line per face. Letters before OFF announce normals
// (N), colours (C), texture (ST); they are read over. The counts may stand on the keyword's line, even glued to it.
#include <algorithm>
#include <cctype>

#include "base/text.hpp"
#include "formats/line_words.hpp"
#include "formats/mesh_builder.hpp"
#include "formats/text_columns.hpp"

namespace scanmill::formats {
namespace {

/// Length of the keyword in front of a word ("OFF490" gives 3), or 0.
std::size_t keyword_length(std::string_view word) {
  const std::size_t off = word.find("OFF");
  if (off == std::string_view::npos) return 0;
  std::string_view letters = word.substr(0, off);
  for (const std::string_view letter : {"ST", "C", "N", "4", "n"})
    if (letters.substr(0, letter.size()) == letter) letters.remove_prefix(letter.size());
  return letters.empty() ? off + 3 : 0;
}

class OffReader {
 public:
  explicit OffReader(const ByteSource& source) : source_(source), lines_(source), builder_(source.name()) {}

  Result<MeshFile> read() {
    builder_.mesh.format = "off";
    TRY(read_counts());
    for (std::uint64_t v = 0; v < vertices_; ++v) TRY(read_vertex(v));
    for (std::uint64_t f = 0; f < faces_; ++f) TRY(read_face(f));
    TRY(look_behind());
    if (vertex_extras_ > 0)
      builder_.skipped("what follows the coordinates of " + grouped(vertex_extras_) + " vertices (colour, normal)");
    if (face_extras_ > 0) builder_.skipped("what follows the corners of " + grouped(face_extras_) + " faces (colour)");
    return builder_.finish();
  }

 private:
  std::string place() const { return line_place(source_.name(), lines_.number()); }

  /// The next line with something on it, without its comment. False at the end of the file.
  Result<bool> next_line(std::string_view& text) {
    while (!lines_.at_end()) {
      TRY_ASSIGN(const std::string_view line, lines_.next());
      const std::size_t hash = line.find('#');
      if (hash != std::string_view::npos) builder_.add_comment(LineWords(line.substr(hash + 1)).rest());
      text = line.substr(0, hash);
      if (LineWords(text).at_end()) continue;
      if (has_carriage_return_inside(line))
        return fail(Code::BadInput, "the lines end in a carriage return alone; convert the line ends", place());
      return true;
    }
    return false;
  }

  Result<void> read_counts() {
    std::string_view line;
    TRY_ASSIGN(bool found, next_line(line));
    const std::size_t length = found ? keyword_length(LineWords(line).next()) : 0;
    if (length > 0) {
      const std::string_view keyword = LineWords(line).next().substr(0, length);
      if (keyword.find_first_of("4n") != std::string_view::npos)
        return fail(Code::Unsupported,
                    "found the keyword " + quoted(keyword) + "; only OFF files of three dimensions are read", place());
      builder_.mesh.format.clear();
      for (const char c : keyword)
        builder_.mesh.format += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
      line.remove_prefix(static_cast<std::size_t>(keyword.data() - line.data()) + length);
      if (is_word(LineWords(line).next(), "binary"))
        return fail(Code::Unsupported, "binary OFF files are not read; convert the file to PLY or ASCII OFF", place());
      if (LineWords(line).at_end()) {
        TRY_ASSIGN(found, next_line(line));
      }
    }
    LineWords words(line);
    std::uint64_t edges = 0;
    if (!found || !words.integer(vertices_) || !words.integer(faces_) || (!words.at_end() && !words.integer(edges)) ||
        !words.at_end())
      return fail(
          Code::BadInput,
          (found ? "found " + quoted(line) : "the file ends") + ", wanted the numbers of vertices, faces and edges",
          place());
    return {};
  }

  Error too_short(const char* what, std::uint64_t declared, std::uint64_t read) const {
    return fail(Code::BadInput,
                "the header declares " + grouped(declared) + " " + what + ", the file ends after " + grouped(read) +
                    "; it was cut or its counts are wrong",
                place());
  }

  Result<void> read_vertex(std::uint64_t number) {
    std::string_view line;
    TRY_ASSIGN(const bool found, next_line(line));
    if (!found) return too_short("vertices", vertices_, number);
    LineWords words(line);
    Vec3 p;
    if (!(words.number(p.x) && words.number(p.y) && words.number(p.z)))
      return fail(Code::BadInput, "found " + quoted(line) + " as vertex " + grouped(number) + ", wanted three numbers",
                  place());
    vertex_extras_ += !words.at_end();
    return builder_.add_vertex(p);
  }

  Result<void> read_face(std::uint64_t number) {
    std::string_view line;
    TRY_ASSIGN(const bool found, next_line(line));
    if (!found) return too_short("faces", faces_, number);
    LineWords words(line);
    std::uint64_t corners = 0, corner = 0;
    corners_.clear();
    bool good = words.integer(corners);
    for (std::uint64_t i = 0; good && i < corners; ++i) {
      good = words.integer(corner);
      if (good) corners_.push_back(corner);
    }
    if (!good)
      return fail(Code::BadInput,
                  "found " + quoted(line) + " as face " + grouped(number) +
                      ", wanted the number of its corners and as many vertex numbers, from 0",
                  place());
    face_extras_ += !words.at_end();
    builder_.add_polygon(corners_, {true, lines_.number()});
    return {};
  }

  Result<void> look_behind() {
    std::string_view line;
    TRY_ASSIGN(const bool found, next_line(line));
    if (found)
      builder_.note("lines behind the last face (from line " + std::to_string(lines_.number()) + ") were not read");
    return {};
  }

  const ByteSource& source_;
  NumberedLines lines_;
  MeshBuilder builder_;
  std::uint64_t vertices_ = 0, faces_ = 0, vertex_extras_ = 0, face_extras_ = 0;
  std::vector<std::uint64_t> corners_;
};

}  // namespace

bool is_off_keyword(std::string_view word) {
  const std::size_t length = keyword_length(word);
  return length > 0 && std::all_of(word.begin() + static_cast<std::ptrdiff_t>(length), word.end(),
                                   [](char c) { return c >= '0' && c <= '9'; });
}

Result<MeshFile> read_off_mesh(const ByteSource& source) { return OffReader(source).read(); }

}  // namespace scanmill::formats
