// SPDX-License-Identifier: Apache-2.0
#include "simulate/bumpy_ball.hpp"

#include <algorithm>
#include <cmath>

#include "base/digest.hpp"

namespace scanmill::simulate {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kWidestCap = 0.8987940462991670;  // sine of 64 degrees: the rim stays in sight over every bump
constexpr double kTimesSeen = 7.3;                 // every place, by so many views
constexpr double kBump = 0.01;
constexpr std::uint64_t kLeastViews = 26, kMostViews = 4096, kPointsPerView = 400'000;
constexpr std::uint64_t kPurpose = 0x7363616c65ull;

/// cos 6t of x = cos t.
double six_times(double x) {
  const double s = x * x;
  return ((32 * s - 48) * s + 18) * s - 1;
}

/// Mean 0, variance 1, within 3.5: the centred sum of the four 16-bit numbers in a mixed word.
double noise_of(std::uint64_t word) {
  const auto sum =
      static_cast<std::int64_t>((word & 0xffff) + (word >> 16 & 0xffff) + (word >> 32 & 0xffff) + (word >> 48));
  constexpr double kDeviation = 37837.22745554488;  // sqrt(4 (2^32 - 1) / 12)
  return static_cast<double>(sum - 131070) / kDeviation;
}

}  // namespace

BumpyBall::BumpyBall(std::uint64_t points, std::uint64_t seed)
    : points_(points),
      seed_(mix64(seed ^ mix64(kPurpose))),
      radius_(std::sqrt(static_cast<double>(points) / (4 * kPi * kPointsPerMm2))) {
  const std::uint64_t views = std::clamp(points / kPointsPerView, kLeastViews, kMostViews);
  cap_ = std::min(kWidestCap, 2 * std::sqrt(kTimesSeen / static_cast<double>(views)));
  axes_.reserve(views);
  // A spiral from pole to pole, a golden angle from view to view.
  constexpr double kCosine = -0.7373688780783197, kSine = 0.6754902942615238;
  Vec3 heading{1, 0, 0};
  for (std::uint64_t v = 0; v < views; ++v) {
    const double z = 1 - static_cast<double>(2 * v + 1) / static_cast<double>(views), ring = std::sqrt(1 - z * z);
    const Vec3 towards{ring * heading.x, ring * heading.y, z};
    const Vec3 u = perpendicular(towards);
    axes_.push_back({u, cross(towards, u), towards});
    heading = unit({kCosine * heading.x - kSine * heading.y, kSine * heading.x + kCosine * heading.y, 0});
  }
  starts_[0] = line_starts(points / views);
  starts_[1] = line_starts(points / views + 1);
}

std::uint64_t BumpyBall::first_of_view(std::size_t view) const {
  const std::uint64_t share = points_ / views(), longer = points_ % views();  // the first ones hold one more
  return share * view + std::min<std::uint64_t>(view, longer);
}

double BumpyBall::reach_mm() const { return radius_ * (1 + 3 * kBump) + 4 * kNoiseMm; }

std::vector<std::uint64_t> BumpyBall::line_starts(std::uint64_t points) {
  const auto lines = static_cast<std::uint64_t>(2 * std::sqrt(static_cast<double>(points) / kPi)) + 1;
  std::vector<double> width(lines + 1);  // of the lines before
  for (std::uint64_t line = 0; line < lines; ++line) {
    const double w = static_cast<double>(2 * line + 1) / static_cast<double>(lines) - 1;
    width[line + 1] = width[line] + std::sqrt(1 - w * w);
  }
  std::vector<std::uint64_t> starts(lines + 1);
  for (std::uint64_t line = 0; line < lines; ++line)
    starts[line] = static_cast<std::uint64_t>(static_cast<double>(points) * (width[line] / width[lines]));
  starts[lines] = points;
  return starts;
}

void BumpyBall::fill_line(const Axes& axes, double w, std::uint64_t columns, std::uint64_t column, std::uint64_t row,
                          std::span<Point> out) const {
  const double half = std::sqrt(std::max(0.0, cap_ * cap_ - w * w));
  const double step = 2 * half / static_cast<double>(columns);
  for (Point& point : out) {
    const double u = (static_cast<double>(column++) + 0.5) * step - half;
    const double out_of_plane = std::sqrt(1 - u * u - w * w);
    const Vec3 d = axes.u * u + axes.w * w + axes.towards * out_of_plane;
    const double r = radius_ * (1 + kBump * (six_times(d.x) + six_times(d.y) + six_times(d.z)));
    const Vec3 p = d * r + axes.towards * (kNoiseMm * noise_of(mix64(seed_ + row++)));
    point = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  }
}

void BumpyBall::fill(std::uint64_t first, std::span<Point> out) const {
  const std::uint64_t share = points_ / views(), longer = points_ % views();
  const std::uint64_t in_longer = longer * (share + 1);
  std::size_t view = static_cast<std::size_t>(
      first < in_longer ? first / (share + 1) : longer + (first - in_longer) / std::max<std::uint64_t>(share, 1));
  while (!out.empty()) {
    const std::uint64_t begin = first_of_view(view), end = first_of_view(view + 1);
    const std::vector<std::uint64_t>& starts = starts_[end - begin - share];
    const std::uint64_t lines = starts.size() - 1;
    auto line =
        static_cast<std::uint64_t>(std::upper_bound(starts.begin(), starts.end(), first - begin) - starts.begin()) - 1;
    for (; line < lines && !out.empty(); ++line) {
      const std::uint64_t column = first - begin - starts[line], columns = starts[line + 1] - starts[line];
      const std::size_t count = static_cast<std::size_t>(std::min<std::uint64_t>(columns - column, out.size()));
      const double w = cap_ * (static_cast<double>(2 * line + 1) / static_cast<double>(lines) - 1);
      fill_line(axes_[view], w, columns, column, first, out.first(count));
      out = out.subspan(count);
      first += count;
    }
    ++view;
  }
}

}  // namespace scanmill::simulate
