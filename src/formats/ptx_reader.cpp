// SPDX-License-Identifier: Apache-2.0
// Leica PTX: scans one behind the other, each with ten header lines (columns, rows, scanner position, three axes, a 4x4
// matrix whose translation is its last row) and one line x y z intensity [r g b] per cell, in the scanner's frame. The
// matrix places the points; position and axes say the same a second time and are only compared with it.
#include <cmath>

#include "base/text.hpp"
#include "formats/counted_lines.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {
namespace {

/// p' = p M with row vectors, as PTX writes it.
struct Affine {
  std::array<double, 9> rows{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major, of the column-vector form
  Vec3 translation;
  Vec3 apply(Vec3 p) const {
    return Vec3{rows[0] * p.x + rows[1] * p.y + rows[2] * p.z, rows[3] * p.x + rows[4] * p.y + rows[5] * p.z,
                rows[6] * p.x + rows[7] * p.y + rows[8] * p.z} +
           translation;
  }
};

struct PtxScan {
  std::uint64_t columns = 0, rows = 0, line = 0;
  Pose pose;
  Affine stretch;  // where the matrix is no rigid pose: applied to the points here
  bool is_stretched = false;
  std::vector<std::string> notes;
  std::vector<TextRun> runs;
};

class PtxReader final : public ViewReader {
 public:
  PtxReader(std::shared_ptr<const ByteSource> source, PtxScan scan)
      : source_(std::move(source)), scan_(std::move(scan)) {
    header_.format = "ptx";
    header_.row_meaning = RowMeaning::LineFromOne;
    header_.rows = scan_.columns * scan_.rows;
    header_.has_grid = true;
    header_.notes = scan_.notes;
    header_.pose = scan_.pose;
    header_.view_point.eye = scan_.is_stretched ? scan_.stretch.apply({}) : Vec3{};
  }

  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return scan_.runs.size(); }
  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    TRY(read_text_run(*source_, scan_.runs[number], TextColumns{}, true, out));
    if (!scan_.is_stretched) return {};
    for (Vec3& p : out.positions) {
      p = scan_.stretch.apply(p);
      if (!is_finite(p))
        return fail(Code::BadInput, "a point leaves the range of numbers under the matrix of its scan",
                    line_place(source_->name(), scan_.line));
    }
    return {};
  }

 private:
  std::shared_ptr<const ByteSource> source_;
  PtxScan scan_;
  ViewHeader header_;
};

class PtxPass {
 public:
  explicit PtxPass(const ByteSource& source) : source_(source), lines_(source) {}

  Result<std::vector<PtxScan>> run() {
    std::vector<PtxScan> scans;
    for (;;) {
      TRY_ASSIGN(const CountedLines::Line first, lines_.next());
      if (first.at_end()) break;
      if (!first.is_count())
        return scans.empty()
                   ? wanted(first, "the number of columns of the scan")
                   : wanted(first, "the end of the file or the number of columns of a further scan; the scan at line " +
                                       std::to_string(scans.back().line) + " declares " + size_text(scans.back()));
      TRY_ASSIGN(PtxScan scan, read_header(first));
      TRY(read_cells(scan));
      scans.push_back(std::move(scan));
    }
    if (scans.empty()) return fail(Code::BadInput, "the file holds no scan, wanted a PTX header", source_.name());
    return scans;
  }

 private:
  static std::string size_text(const PtxScan& scan) {
    return std::to_string(scan.columns) + " x " + std::to_string(scan.rows) + " = " +
           std::to_string(scan.columns * scan.rows) + " cells";
  }

  Error wanted(const CountedLines::Line& line, const std::string& what) const {
    if (line.at_end())
      return fail(Code::BadInput, "the file ends within the header of a scan, wanted " + what + "; it was cut",
                  line_place(source_.name(), lines_.line_number()));
    return fail(Code::BadInput, "found " + quoted(line.text) + ", wanted " + what,
                line_place(source_.name(), line.line));
  }

  Result<void> read_numbers(std::size_t count, double* out, const char* what) {
    TRY_ASSIGN(const CountedLines::Line line, lines_.next());
    bool good = line.numbers.size() == count;
    for (const double value : line.numbers) good = good && std::isfinite(value);
    if (!good) return wanted(line, std::to_string(count) + " numbers: " + what);
    std::copy(line.numbers.begin(), line.numbers.end(), out);
    return {};
  }

  Result<PtxScan> read_header(const CountedLines::Line& first) {
    PtxScan scan;
    scan.line = first.line;
    scan.columns = first.count();
    TRY_ASSIGN(const CountedLines::Line second, lines_.next());
    if (!second.is_count()) return wanted(second, "the number of rows of the scan");
    scan.rows = second.count();
    // A cell takes two bytes at least ("0 0 0" six); this also keeps the product from overflowing.
    if (scan.columns > 0 && scan.rows > source_.size() / scan.columns)
      return fail(Code::BadInput,
                  "the scan declares " + std::to_string(scan.columns) + " x " + std::to_string(scan.rows) +
                      " cells, the whole file has " + std::to_string(source_.size()) +
                      " bytes; it was cut or the header is wrong",
                  line_place(source_.name(), scan.line));
    std::array<double, 3> position{};
    std::array<double, 9> axes{};
    TRY(read_numbers(3, position.data(), "the scanner's position"));
    for (std::size_t i = 0; i < 3; ++i) TRY(read_numbers(3, axes.data() + 3 * i, "an axis of the scanner"));
    const std::uint64_t line = lines_.line_number();
    std::array<double, 16> m{};
    for (std::size_t i = 0; i < 4; ++i) TRY(read_numbers(4, m.data() + 4 * i, "a row of the 4x4 matrix"));
    TRY(take_matrix(m, line, scan));
    compare(position, axes, m, scan);
    return scan;
  }

  Result<void> take_matrix(const std::array<double, 16>& m, std::uint64_t line, PtxScan& scan) const {
    const std::string place = line_place(source_.name(), line);
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
      return fail(Code::BadInput,
                  "the last column of the scan's 4x4 matrix is " + number_text(m[3]) + " " + number_text(m[7]) + " " +
                      number_text(m[11]) + " " + number_text(m[15]) +
                      ", wanted 0 0 0 1: PTX has the translation in the last row",
                  place);
    const Vec3 x{m[0], m[1], m[2]}, y{m[4], m[5], m[6]}, z{m[8], m[9], m[10]};
    const double volume = dot(cross(x, y), z), size = norm(x) * norm(y) * norm(z);
    if (!(std::abs(volume) > 1e-9 * size))
      return fail(Code::BadInput, "the scan's 4x4 matrix flattens space, so it cannot place the points", place);
    const Vec3 translation{m[12], m[13], m[14]};
    const auto pose =
        pose_from_matrix({m[0], m[4], m[8], m[12], m[1], m[5], m[9], m[13], m[2], m[6], m[10], m[14], 0, 0, 0, 1});
    if (pose.ok()) {
      scan.pose = *pose;
      return {};
    }
    scan.is_stretched = true;
    scan.stretch = {{m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]}, translation};
    scan.notes.push_back("the 4x4 matrix at line " + std::to_string(line) +
                         " is no rigid pose (it scales, shears or mirrors); it is applied as written");
    return {};
  }

  static void compare(const std::array<double, 3>& position, const std::array<double, 9>& axes,
                      const std::array<double, 16>& m, PtxScan& scan) {
    double size = 1, off = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      size = std::max(size, std::abs(m[12 + i]));
      off = std::max(off, std::abs(position[i] - m[12 + i]));
      for (std::size_t j = 0; j < 3; ++j)
        if (std::abs(axes[3 * i + j] - m[4 * i + j]) > 1e-3) off = size;
    }
    if (off > 1e-3 * size)
      scan.notes.push_back("scanner position and axes at line " + std::to_string(scan.line + 2) +
                           " differ from the 4x4 matrix below them; the matrix is taken");
  }

  Result<void> read_cells(PtxScan& scan) {
    std::uint64_t found = 0;
    const std::uint64_t cells = scan.columns * scan.rows;
    TRY_ASSIGN(scan.runs, lines_.rows(cells, found));
    if (found == cells) return {};
    return fail(Code::BadInput,
                "the scan declares " + size_text(scan) + ", the file ends after " + std::to_string(found) +
                    " of them; it was cut or the header is wrong",
                line_place(source_.name(), scan.line));
  }

  const ByteSource& source_;
  CountedLines lines_;
};

}  // namespace

Result<std::vector<std::unique_ptr<ViewReader>>> open_ptx(std::shared_ptr<const ByteSource> source) {
  TRY_ASSIGN(std::vector<PtxScan> scans, PtxPass(*source).run());
  std::vector<std::unique_ptr<ViewReader>> readers;
  for (PtxScan& scan : scans) readers.push_back(std::make_unique<PtxReader>(source, std::move(scan)));
  return readers;
}

}  // namespace scanmill::formats
