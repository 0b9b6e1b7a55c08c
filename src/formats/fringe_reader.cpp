// SPDX-License-Identifier: Apache-2.0
// Pictures of shifted fringes as points of a view.
#include "base/text.hpp"
#include "formats/fringe_set.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {
namespace {

class FringeReader final : public ViewReader {
 public:
  FringeReader(std::string name, FringeSet set, OpenBeside open, std::uint64_t pixels)
      : name_(std::move(name)), set_(std::move(set)), open_(std::move(open)) {
    header_.format = "fringes";
    header_.row_meaning = RowMeaning::PixelFromZero;
    header_.rows = pixels;
    header_.has_grid = true;
    header_.view_point.eye = Vec3{};
    std::size_t named = 0;
    for (const FringeGrating& grating : set_.gratings) named += grating.object.size() + grating.plate.size();
    if (set_.sha256.size() < named)
      header_.notes.push_back(
          "not every picture has its sha256 here: a later run does not notice when one is exchanged");
  }

  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return 1; }
  Result<void> read_block(std::size_t, PointBlock& out) const override {
    out.clear();
    TRY_ASSIGN(const fringe::RangeMap map, decode_fringes(set_, open_, name_));
    out.points_read = map.points.size();
    for (std::size_t i = 0; i < map.points.size(); ++i) {
      if (map.flaws[i] != fringe::Flaw::None) {
        ++out.sensor_invalid;
        continue;
      }
      out.positions.push_back(map.points[i]);
      out.rows.push_back(i);
    }
    return {};
  }

 private:
  std::string name_;
  FringeSet set_;
  OpenBeside open_;
  ViewHeader header_;
};

}  // namespace

Result<std::unique_ptr<ViewReader>> open_fringes(std::shared_ptr<const ByteSource> source, const OpenOptions& options) {
  TRY_ASSIGN(FringeSet set, read_fringe_set(*source));
  if (!options.open_beside)
    return fail(Code::Unsupported, "pictures beside the text cannot be opened here", source->name());
  const auto size = fringe_size(set, options.open_beside);
  if (!size.ok()) return Error(size.error()).at(source->name());  // the text that names the picture, too
  const auto pixels = static_cast<std::uint64_t>(size->first) * static_cast<std::uint64_t>(size->second);
  return std::unique_ptr<ViewReader>(
      std::make_unique<FringeReader>(source->name(), std::move(set), options.open_beside, pixels));
}

}  // namespace scanmill::formats
