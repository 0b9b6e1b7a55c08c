// SPDX-License-Identifier: Apache-2.0
// Depth maps: one point per pixel, in the frame of the camera.
#include <atomic>

#include "formats/png.hpp"
#include "formats/readers.hpp"

namespace scanmill::formats {
namespace {

constexpr std::size_t kBlockPixels = 65536;

/// The image a thread decoded last: blocks of one image are mostly read one behind the other.
struct LastImage {
  std::uint64_t reader = 0;
  std::vector<std::uint16_t> pixels;
};

class DepthReader final : public ViewReader {
 public:
  DepthReader(std::shared_ptr<const ByteSource> source, PngFile file, const DepthCamera& camera)
      : source_(std::move(source)), file_(std::move(file)), camera_(camera) {
    static std::atomic<std::uint64_t> next{1};
    number_ = next.fetch_add(1, std::memory_order_relaxed);
    lines_ = std::max<std::size_t>(1, kBlockPixels / file_.width);
    header_.format = "png depth map";
    header_.row_meaning = RowMeaning::PixelFromZero;
    header_.rows = std::uint64_t{file_.width} * file_.height;
    header_.has_grid = true;
    header_.view_point.eye = Vec3{};
  }

  const ViewHeader& header() const override { return header_; }
  std::size_t block_count() const override { return (file_.height + lines_ - 1) / lines_; }

  Result<void> read_block(std::size_t number, PointBlock& out) const override {
    thread_local LastImage image;
    if (image.reader != number_) {
      image.reader = 0;
      TRY(read_png(*source_, file_, image.pixels));
      image.reader = number_;
    }
    const std::size_t width = file_.width, begin = number * lines_;
    const std::size_t end = std::min<std::size_t>(file_.height, begin + lines_);
    out.clear();
    out.points_read = (end - begin) * width;
    for (std::size_t v = begin; v < end; ++v)
      for (std::size_t u = 0; u < width; ++u) {
        const std::uint16_t value = image.pixels[v * width + u];
        if (value == 0) {
          ++out.sensor_invalid;
          continue;
        }
        const double z = value / camera_.depth_scale;
        const Vec3 p{(static_cast<double>(u) - camera_.cx) * z / camera_.fx,
                     (static_cast<double>(v) - camera_.cy) * z / camera_.fy, z};
        if (!is_finite(p)) {
          ++out.not_finite;
          continue;
        }
        out.positions.push_back(p);
        out.rows.push_back(v * width + u);
      }
    return {};
  }

 private:
  std::shared_ptr<const ByteSource> source_;
  PngFile file_;
  DepthCamera camera_;
  std::uint64_t number_ = 0;  // no two readers of a process share it
  std::size_t lines_ = 1;     // image rows per block
  ViewHeader header_;
};

}  // namespace

Result<std::unique_ptr<ViewReader>> open_depth_map(std::shared_ptr<const ByteSource> source,
                                                   const DepthCamera& camera) {
  TRY_ASSIGN(PngFile file, open_png(*source));
  return std::unique_ptr<ViewReader>(std::make_unique<DepthReader>(std::move(source), std::move(file), camera));
}

}  // namespace scanmill::formats
