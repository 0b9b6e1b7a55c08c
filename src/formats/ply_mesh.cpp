// SPDX-License-Identifier: Apache-2.0
// PLY with faces, read from front to back: vertices, faces (vertex_indices or vertex_index), triangle strips of the
// Stanford archive; other elements are passed over.
#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.hpp"
#include "formats/line_words.hpp"
#include "formats/mesh_builder.hpp"
#include "formats/ply_header.hpp"
#include "formats/ply_layout.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kPeek = 1 << 15;

/// Values of one row, one after the other, the same for ascii and binary. Between rows `begin_row` is called.
class RowValues {
 public:
  RowValues(const ByteSource& source, const PlyHeader& header)
      : source_(source),
        header_(header),
        ascii_(header.encoding == PlyEncoding::Ascii),
        swap_(header.swaps_bytes()),
        cursor_(source, header.data_offset),
        line_(header.data_line - 1) {}

  Place place() const { return ascii_ ? Place{true, line_} : Place{false, row_offset_}; }
  std::uint64_t bytes_left() const { return source_.size() - std::min(source_.size(), cursor_.offset()); }
  bool ascii() const { return ascii_; }

  Result<void> begin_row(const PlyElement& element, std::uint64_t row) {
    element_ = &element;
    row_ = row;
    row_offset_ = cursor_.offset();
    if (!ascii_) return {};
    do {
      if (cursor_.at_end()) return cut();
      if (!cursor_.line_at_hand(text_)) {
        TRY_ASSIGN(text_, cursor_.line());
      }
      words_ = LineWords(text_);
      ++line_;
    } while (words_.at_end());
    return {};
  }

  Result<double> value(PlyType type, const PlyProperty& property) {
    if (ascii_) {
      double number = 0;
      if (words_.number(number)) return number;
      const std::string_view word = words_.next();
      return fail(Code::BadInput,
                  word.empty() ? "found " + quoted(text_) + ", the line ends before property " + quoted(property.name) +
                                     " of element " + quoted(element_->name)
                               : "found " + quoted(word) + " as " + quoted(property.name) + ", wanted a number",
                  place().text(source_.name()));
    }
    const std::size_t size = size_of(type);
    if (at_ + size > window_.size()) TRY(refill(size));
    const double number = load_value(type, swap_, window_.data() + at_);
    at_ += size;
    return number;
  }

  /// The length of a list, once the bytes that are left can hold it.
  Result<std::uint64_t> list_length(const PlyProperty& property) {
    TRY_ASSIGN(const double count, value(property.count_type, property));
    // An ascii item takes a blank and a digit at least.
    const std::uint64_t most = ascii_ ? text_.size() / 2 : unread() / size_of(property.type);
    if (!(count >= 0) || count != std::floor(count))
      return fail(Code::BadInput,
                  "the list " + quoted(property.name) + " has the length " + number_text(count) +
                      "; wanted a whole number, 0 or more",
                  place().text(source_.name()));
    if (count > static_cast<double>(most))
      return fail(Code::BadInput,
                  "the list " + quoted(property.name) + " announces " + number_text(count) + " items, " +
                      (ascii_ ? "the line" : "the rest of the file") + " can hold " + grouped(most) + " at most",
                  place().text(source_.name()));
    return static_cast<std::uint64_t>(count);
  }

  Result<void> end_row() {
    if (ascii_ && !words_.at_end())
      return fail(Code::BadInput,
                  "found " + quoted(words_.next()) + " behind the last of the " +
                      std::to_string(element_->properties.size()) +
                      " properties that the header declares for element " + quoted(element_->name),
                  place().text(source_.name()));
    settle();
    return {};
  }

  /// Passes over all rows of an element.
  Result<void> pass_over(const PlyElement& element) {
    if (!ascii_ && !element.has_lists) {
      if (element.count > bytes_left() / std::max<std::uint64_t>(element.stride, 1)) {
        element_ = &element;
        row_ = bytes_left() / std::max<std::uint64_t>(element.stride, 1);
        return cut();
      }
      cursor_.skip(element.count * element.stride);
      return {};
    }
    for (std::uint64_t row = 0; row < element.count; ++row) {
      if (ascii_)
        TRY(begin_row(element, row));
      else
        TRY(skip_row(cursor_, source_, header_, element, row));
    }
    return {};
  }

  std::string rest_note() {
    if (bytes_left() == 0) return {};
    if (ascii_) {
      const std::uint64_t from = cursor_.offset();
      while (!cursor_.at_end()) {
        const auto line = cursor_.line();
        if (!line.ok() || !LineWords(*line).at_end())
          return "lines behind the last element (from byte " + std::to_string(from) + ") were not read";
      }
      return {};
    }
    return grouped(bytes_left()) + " bytes behind the last element (from byte " + std::to_string(cursor_.offset()) +
           ") were not read";
  }

 private:
  Error cut() const {
    return fail(Code::BadInput,
                "the header declares " + grouped(element_->count) + " rows of element " + quoted(element_->name) +
                    ", the file ends after " + grouped(row_) + "; it was cut or its header is wrong",
                byte_place(source_.name(), source_.size()));
  }

  // Binary values come out of a window over the cursor, so that a value costs no look at the source.
  std::uint64_t unread() const { return bytes_left() - at_; }
  void settle() {
    cursor_.skip(at_);
    window_ = {};
    at_ = 0;
  }
  Result<void> refill(std::size_t size) {
    settle();
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(bytes_left(), kPeek));
    if (wanted < size) return cut();
    TRY_ASSIGN(window_, cursor_.peek(wanted));
    return {};
  }

  const ByteSource& source_;
  const PlyHeader& header_;
  bool ascii_, swap_;
  Cursor cursor_;
  std::uint64_t line_, row_ = 0, row_offset_ = 0;
  const PlyElement* element_ = nullptr;
  std::string_view text_, window_;
  std::size_t at_ = 0;
  LineWords words_{{}};
};

class PlyMeshReader {
 public:
  PlyMeshReader(const ByteSource& source, PlyHeader header)
      : source_(source), header_(std::move(header)), builder_(source.name()), rows_(source, header_) {}

  Result<MeshFile> read() {
    builder_.mesh.format = header_.format_name();
    for (const std::string& comment : header_.comments) builder_.add_comment(comment);
    for (const std::string& note : header_.notes) builder_.note(note);
    if (header_.find("vertex") < 0)
      return fail(Code::BadInput, "the header declares no element \"vertex\", so there is no mesh", source_.name());
    if (header_.find("face") < 0 && header_.find("tristrips") < 0)
      return fail(Code::BadInput, "the header declares no element \"face\": the file is a cloud, wanted a mesh",
                  source_.name());
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex")
        TRY(read_vertices(element));
      else if (element.name == "face")
        TRY(read_faces(element));
      else if (element.name == "tristrips")
        TRY(read_strips(element));
      else
        TRY(pass_over(element));
    }
    if (const std::string note = rows_.rest_note(); !note.empty()) builder_.note(note);
    if (builder_.mesh.patch.size() != builder_.mesh.triangles.size()) builder_.mesh.patch.clear();
    return builder_.finish();
  }

 private:
  Result<void> pass_over(const PlyElement& element) {
    if (element.count > 0)
      builder_.skipped("element " + quoted(element.name) + " with " + grouped(element.count) + " rows");
    return rows_.pass_over(element);
  }

  /// Reads over one property of the row.
  Result<void> pass(const PlyProperty& property) {
    std::uint64_t count = 1;
    if (property.is_list) {
      TRY_ASSIGN(count, rows_.list_length(property));
    }
    for (std::uint64_t i = 0; i < count; ++i) {
      TRY_ASSIGN([[maybe_unused]] const double value, rows_.value(property.type, property));
    }
    return {};
  }

  Result<void> read_vertices(const PlyElement& element) {
    static constexpr std::string_view kNames[][2] = {
        {"x", "X"}, {"y", "Y"}, {"z", "Z"}, {"error", "error"}, {"error_rms", "error_rms"}};
    std::vector<int> use(element.properties.size(), -1);  // which of the five a property is
    std::array<bool, 5> have{};
    for (int k = 0; k < 5; ++k)
      for (const std::string_view name : kNames[k]) {
        const int column = element.find_scalar(name);
        if (column < 0 || have[static_cast<std::size_t>(k)]) continue;
        use[static_cast<std::size_t>(column)] = k;
        have[static_cast<std::size_t>(k)] = true;
      }
    if (!(have[0] && have[1] && have[2]))
      return fail(Code::BadInput, "element \"vertex\" has no number properties x, y and z", source_.name());
    tell_form(element, use);
    for (std::uint64_t row = 0; row < element.count; ++row) {
      TRY(rows_.begin_row(element, row));
      std::array<double, 5> values{};
      for (std::size_t i = 0; i < use.size(); ++i) {
        if (use[i] < 0) {
          TRY(pass(element.properties[i]));
          continue;
        }
        TRY_ASSIGN(values[static_cast<std::size_t>(use[i])],
                   rows_.value(element.properties[i].type, element.properties[i]));
      }
      TRY(rows_.end_row());
      TRY(builder_.add_vertex({values[0], values[1], values[2]}));
      if (have[3]) builder_.mesh.error.push_back(values[3]);
      if (have[4]) builder_.mesh.error_rms.push_back(values[4]);
    }
    return {};
  }

  void tell_form(const PlyElement& element, const std::vector<int>& use) {
    bool narrow = true;
    for (std::size_t i = 0; i < use.size(); ++i) {
      if (use[i] < 0) builder_.skipped("property " + quoted(element.properties[i].name) + " of the vertices");
      const PlyType type = element.properties[i].type;
      if (use[i] >= 0 && use[i] < 3)
        narrow &= type != PlyType::Float64 && type != PlyType::Int32 && type != PlyType::UInt32;
    }
    if (!rows_.ascii()) builder_.mesh.coordinates = narrow ? CoordinateForm::Float32 : CoordinateForm::Float64;
  }

  static bool is_whole_type(PlyType type) { return type != PlyType::Float32 && type != PlyType::Float64; }

  Result<std::uint64_t> corner(const PlyProperty& property) {
    TRY_ASSIGN(const double value, rows_.value(property.type, property));
    if (!(value >= 0) || value != std::floor(value) || value > 0x1p53)
      return fail(Code::BadInput, "found vertex number " + number_text(value) + ", wanted a whole number from 0",
                  rows_.place().text(source_.name()));
    return static_cast<std::uint64_t>(value);
  }

  Result<void> read_faces(const PlyElement& element) {
    int list = -1, patch = -1;
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      if (property.is_list && (property.name == "vertex_indices" || property.name == "vertex_index"))
        list = static_cast<int>(i);
      else if (!property.is_list && property.name == "patch" && is_whole_type(property.type))
        patch = static_cast<int>(i);
      else if (element.count > 0)
        builder_.skipped("property " + quoted(property.name) + " of the faces");
    }
    if (list < 0 && element.count > 0)
      return fail(Code::BadInput, "element \"face\" has no list property vertex_indices or vertex_index",
                  source_.name());
    for (std::uint64_t row = 0; row < element.count; ++row) {
      TRY(rows_.begin_row(element, row));
      double patch_id = 0;
      for (std::size_t i = 0; i < element.properties.size(); ++i) {
        const PlyProperty& property = element.properties[i];
        if (static_cast<int>(i) == patch) {
          TRY_ASSIGN(patch_id, rows_.value(property.type, property));
        } else if (static_cast<int>(i) != list) {
          TRY(pass(property));
        } else {
          TRY(read_corners(property));
        }
      }
      TRY(rows_.end_row());
      builder_.add_polygon(corners_, rows_.place());
      if (patch >= 0) TRY(add_patch(patch_id));
    }
    return {};
  }

  Result<void> read_corners(const PlyProperty& property) {
    TRY_ASSIGN(const std::uint64_t count, rows_.list_length(property));
    corners_.clear();
    for (std::uint64_t i = 0; i < count; ++i) {
      TRY_ASSIGN(const std::uint64_t row, corner(property));
      corners_.push_back(row);
    }
    return {};
  }

  Result<void> add_patch(double id) {
    if (!(id >= 0 && id <= 0xffffffffp0) || id != std::floor(id))
      return fail(Code::BadInput, "found patch " + number_text(id) + ", wanted a whole number from 0 to 2^32 - 1",
                  rows_.place().text(source_.name()));
    builder_.mesh.patch.resize(builder_.mesh.triangles.size(), static_cast<std::uint32_t>(id));
    return {};
  }

  /// Every three neighbours of a strip are a triangle, every second one turned; -1 begins a new strip.
  Result<void> read_strips(const PlyElement& element) {
    for (std::uint64_t row = 0; row < element.count; ++row) {
      TRY(rows_.begin_row(element, row));
      for (const PlyProperty& property : element.properties) {
        if (!property.is_list || (property.name != "vertex_indices" && property.name != "vertex_index")) {
          TRY(pass(property));
          continue;
        }
        TRY_ASSIGN(const std::uint64_t count, rows_.list_length(property));
        TRY(read_strip(property, count));
      }
      TRY(rows_.end_row());
    }
    return {};
  }

  Result<void> read_strip(const PlyProperty& property, std::uint64_t count) {
    std::array<std::uint64_t, 3> last{};
    std::uint64_t length = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      TRY_ASSIGN(const double value, rows_.value(property.type, property));
      if (value == -1) {
        length = 0;
        continue;
      }
      if (!(value >= 0) || value != std::floor(value) || value > 0x1p53)
        return fail(Code::BadInput,
                    "found vertex number " + number_text(value) + ", wanted -1 or a whole number from 0",
                    rows_.place().text(source_.name()));
      last = {last[1], last[2], static_cast<std::uint64_t>(value)};
      if (++length < 3) continue;
      const bool even = length % 2 == 1;
      const std::array<std::uint64_t, 3> triangle{last[even ? 0 : 1], last[even ? 1 : 0], last[2]};
      // A vertex twice turns a strip round a corner; it is no face.
      if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
        builder_.add_polygon(triangle, rows_.place());
    }
    return {};
  }

  const ByteSource& source_;
  PlyHeader header_;
  MeshBuilder builder_;
  RowValues rows_;
  std::vector<std::uint64_t> corners_;
};

}  // namespace

Result<MeshFile> read_ply_mesh(const ByteSource& source) {
  TRY_ASSIGN(PlyHeader header, read_ply_header(source));
  return PlyMeshReader(source, std::move(header)).read();
}

}  // namespace scanmill::formats
