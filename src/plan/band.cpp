// SPDX-License-Identifier: Apache-2.0
#include "plan/band.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace scanmill::plan {

void BandCounts::add(const BandCounts& other) {
  points += other.points;
  too_near += other.too_near;
  too_far += other.too_far;
  beside += other.beside;
  nearest_mm = std::min(nearest_mm, other.nearest_mm);
  farthest_mm = std::max(farthest_mm, other.farthest_mm);
  beside_mm = std::max(beside_mm, other.beside_mm);
}

void count_band(const Sensor& sensor, std::span<const Vec3> points, BandCounts& counts) {
  const double slack = 4 * sensor.noise_mm + 1e-6 * sensor.stand_off_mm;
  const double low = sensor.stand_off_mm - sensor.depth_mm - slack;
  const double high = sensor.stand_off_mm + sensor.depth_mm + slack;
  const double half_x = sensor.field_x_mm * (0.5 + 1 / static_cast<double>(sensor.pixels_x)) + slack;
  const double half_y = sensor.field_y_mm * (0.5 + 1 / static_cast<double>(sensor.pixels_y)) + slack;
  counts.points += points.size();
  for (const Vec3 p : points) {
    counts.nearest_mm = std::min(counts.nearest_mm, p.z);
    counts.farthest_mm = std::max(counts.farthest_mm, p.z);
    counts.too_near += p.z < low;
    counts.too_far += p.z > high;
    const double widen = sensor.perspective ? p.z / sensor.stand_off_mm : 1;
    const double off = std::max(std::abs(p.x) - half_x * widen, std::abs(p.y) - half_y * widen);
    if (!(off > 0)) continue;
    ++counts.beside;
    counts.beside_mm = std::max(counts.beside_mm, off);
  }
}

std::vector<Finding> band_findings(const Sensor& sensor, const std::string& station, const BandCounts& counts) {
  std::vector<Finding> findings;
  const auto severity = [&](std::uint64_t outside) {
    return static_cast<double>(outside) > kMostOutside * static_cast<double>(counts.points) ? Severity::Error
                                                                                            : Severity::Warning;
  };
  const std::string of_all = " of " + grouped(counts.points) + " points ";
  if (const std::uint64_t outside = counts.too_near + counts.too_far; outside > 0) {
    const double low = sensor.stand_off_mm - sensor.depth_mm, high = sensor.stand_off_mm + sensor.depth_mm;
    const bool near = low - counts.nearest_mm > counts.farthest_mm - high;
    findings.push_back(
        {severity(outside), "depth", station, "", near ? counts.nearest_mm : counts.farthest_mm, near ? low : high,
         "station " + station + ": " + grouped(outside) + of_all + "lie outside the sensor's depth band of " +
             rounded(low) + " to " + rounded(high) + " mm (found " + rounded(counts.nearest_mm) + " to " +
             rounded(counts.farthest_mm) + " mm)"});
  }
  if (counts.beside > 0)
    findings.push_back({severity(counts.beside), "field", station, "", counts.beside_mm, 0,
                        "station " + station + ": " + grouped(counts.beside) + of_all +
                            "lie beside the sensor's field of " + rounded(sensor.field_x_mm) + " x " +
                            rounded(sensor.field_y_mm) + " mm, by up to " + rounded(counts.beside_mm) + " mm"});
  return findings;
}

}  // namespace scanmill::plan
