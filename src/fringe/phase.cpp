// SPDX-License-Identifier: Apache-2.0
#include "fringe/phase.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "base/text.hpp"
#include "geom/angles.hpp"

namespace scanmill::fringe {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// To [-0.5, 0.5).
double wrapped(double turns) { return turns - std::floor(turns + 0.5); }

/// Weights of the shifts: cosines and sines of k / N turns.
struct Weights {
  std::vector<double> cosine, sine;
  explicit Weights(std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) {
      const SineCosine turn = sine_cosine_of(360.0 * static_cast<double>(k) / static_cast<double>(count));
      cosine.push_back(turn.cosine);
      sine.push_back(turn.sine);
    }
  }
  Wave wave(std::span<const double> samples) const {
    double c = 0, s = 0, sum = 0;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      c += samples[k] * cosine[k];
      s -= samples[k] * sine[k];
      sum += samples[k];
    }
    const double n = static_cast<double>(samples.size());
    const double degrees = degrees_of(std::abs(s), c);
    return {(s < 0 ? -degrees : degrees) / 360, sum / n, 2 / n * std::sqrt(c * c + s * s)};
  }
};

Result<void> check(const Optics& optics, std::span<const Shifted> gratings) {
  for (const auto& problem : problems_of(Optics::fields(), &optics)) return fail(Code::BadParameter, problem);
  if (gratings.empty()) return fail(Code::BadInput, "found no grating; wanted pictures of at least one");
  if (optics.depth_mm >= optics.stand_off_mm)
    return fail(Code::BadParameter, "depth_mm reaches behind the camera; it must be below stand_off_mm");
  const Picture* first = nullptr;
  for (std::size_t g = 0; g < gratings.size(); ++g) {
    const Shifted& grating = gratings[g];
    const std::string name = "grating " + std::to_string(g + 1);
    if (!(grating.period_mm > 0)) return fail(Code::BadParameter, name + ": period_mm must be above 0");
    if (g > 0 && !(grating.period_mm < gratings[g - 1].period_mm))
      return fail(Code::BadParameter,
                  name + ": found a period that is not below the one before it; list the coarsest first");
    if (grating.object.size() < 3 || grating.object.size() != grating.plate.size())
      return fail(Code::BadInput, name + ": found " + std::to_string(grating.object.size()) +
                                      " pictures of the object and " + std::to_string(grating.plate.size()) +
                                      " of the plate, wanted as many of both, at least 3");
    for (const auto* pictures : {&grating.object, &grating.plate})
      for (const Picture& picture : *pictures) {
        if (first == nullptr) first = &picture;
        if (picture.width != first->width || picture.height != first->height ||
            picture.pixels.size() != static_cast<std::size_t>(picture.width * picture.height))
          return fail(Code::BadInput, name + ": found a picture of " + std::to_string(picture.width) + " x " +
                                          std::to_string(picture.height) + " pixels, wanted " +
                                          std::to_string(first->width) + " x " + std::to_string(first->height) +
                                          " as in the first");
      }
  }
  if (gratings.size() == 1) return {};
  const double near = optics.stand_off_mm - optics.depth_mm;
  const double widest = std::abs(optics.baseline_mm) * (optics.stand_off_mm / near - 1);
  if (gratings[0].period_mm < 2 * widest)
    return fail(Code::BadParameter, "the coarsest grating has a period of " + number_text(gratings[0].period_mm) +
                                        ", the depth band needs at least " + number_text(2 * widest) +
                                        "; add a coarser one first");
  return {};
}

class Decoder {
 public:
  Decoder(const Optics& optics, std::span<const Shifted> gratings, std::uint16_t white, const Quality& quality)
      : optics_(optics), gratings_(gratings), white_(white), quality_(quality) {
    map_.width = gratings[0].object[0].width;
    map_.height = gratings[0].object[0].height;
    const auto pixels = static_cast<std::size_t>(map_.width * map_.height);
    map_.wrapped.assign(pixels, kNaN);
    map_.unwrapped.assign(pixels, kNaN);
    map_.visibility.assign(pixels, 1);
    map_.flaws.assign(pixels, Flaw::None);
    map_.points.assign(pixels, Vec3{kNaN, kNaN, kNaN});
  }

  RangeMap run() {
    for (std::size_t g = 0; g < gratings_.size(); ++g) add_grating(g);
    if (gratings_.size() == 1) unwrap_by_neighbours();
    place();
    return std::move(map_);
  }

 private:
  /// Phase difference by one grating; behind the first, with the turns of the one before.
  void add_grating(std::size_t g) {
    const Shifted& grating = gratings_[g];
    const Weights weights(grating.object.size());
    std::vector<double> object(grating.object.size()), plate(object.size());
    for (std::size_t i = 0; i < map_.flaws.size(); ++i) {
      if (map_.flaws[i] != Flaw::None) continue;
      std::uint16_t brightest = 0;
      for (std::size_t k = 0; k < object.size(); ++k) {
        const std::uint16_t a = grating.object[k].pixels[i], b = grating.plate[k].pixels[i];
        object[k] = a;
        plate[k] = b;
        brightest = std::max({brightest, a, b});
      }
      const Wave of_object = weights.wave(object), of_plate = weights.wave(plate);
      map_.flaws[i] = brightest >= white_ ? Flaw::Saturated : std::max(flaw_of(of_object), flaw_of(of_plate));
      const double visibility = of_object.mean > 0 ? of_object.modulation / of_object.mean : 0;
      map_.visibility[i] = std::min(map_.visibility[i], static_cast<float>(visibility));
      if (map_.flaws[i] != Flaw::None) continue;
      const double turns = wrapped(of_object.turns - of_plate.turns);
      map_.wrapped[i] = turns;
      if (g == 0) {
        map_.unwrapped[i] = turns;
        continue;
      }
      const double wanted = map_.unwrapped[i] * gratings_[g - 1].period_mm / grating.period_mm;
      map_.unwrapped[i] = turns + std::floor(wanted - turns + 0.5);
      if (std::abs(map_.unwrapped[i] - wanted) > quality_.max_disagreement) map_.flaws[i] = Flaw::Ambiguous;
    }
  }

  Flaw flaw_of(const Wave& wave) const {
    if (wave.modulation < quality_.min_modulation * white_) return Flaw::Dark;
    if (wave.modulation < quality_.min_visibility * wave.mean) return Flaw::Shadow;
    return Flaw::None;
  }

  struct Step {
    float visibility;
    std::uint32_t to, from;
    /// The best first, then the first in the picture.
    bool operator<(const Step& other) const {
      if (visibility != other.visibility) return visibility < other.visibility;
      return to != other.to ? to > other.to : from > other.from;
    }
  };

  void unwrap_by_neighbours() {
    std::vector<std::uint8_t> done(map_.flaws.size(), 0);
    std::vector<std::uint32_t> seeds;
    for (std::size_t i = 0; i < map_.flaws.size(); ++i)
      if (map_.flaws[i] == Flaw::None) seeds.push_back(static_cast<std::uint32_t>(i));
    std::stable_sort(seeds.begin(), seeds.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return map_.visibility[a] > map_.visibility[b]; });
    std::vector<std::uint32_t> region;
    for (const std::uint32_t seed : seeds) {
      if (done[seed]) continue;
      ++map_.regions;
      region.clear();
      grow(seed, done, region);
      // Whole turns so that the region's mean is nearest to the plate.
      double sum = 0;
      for (const std::uint32_t i : region) sum += map_.unwrapped[i];
      const double turns = std::floor(sum / static_cast<double>(region.size()) + 0.5);
      for (const std::uint32_t i : region) map_.unwrapped[i] -= turns;
    }
  }

  void grow(std::uint32_t seed, std::vector<std::uint8_t>& done, std::vector<std::uint32_t>& region) {
    std::priority_queue<Step> steps;
    steps.push({map_.visibility[seed], seed, seed});
    while (!steps.empty()) {
      const Step step = steps.top();
      steps.pop();
      if (done[step.to]) continue;
      done[step.to] = 1;
      region.push_back(step.to);
      if (step.to != step.from) {
        const double before = map_.unwrapped[step.from];
        map_.unwrapped[step.to] = before + wrapped(map_.wrapped[step.to] - before);
      }
      const std::int64_t x = step.to % map_.width, y = step.to / map_.width;
      for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
        if (x + dx < 0 || x + dx >= map_.width || y + dy < 0 || y + dy >= map_.height) continue;
        const auto next = static_cast<std::uint32_t>((y + dy) * map_.width + x + dx);
        if (!done[next] && map_.flaws[next] == Flaw::None) steps.push({map_.visibility[next], next, step.to});
      }
    }
  }

  /// Phases to depths to points.
  void place() {
    const double period = gratings_.back().period_mm;
    for (std::size_t i = 0; i < map_.flaws.size(); ++i) {
      if (map_.flaws[i] == Flaw::None) {
        const double z = optics_.depth_of(map_.unwrapped[i] * period);
        if (z >= optics_.stand_off_mm - optics_.depth_mm && z <= optics_.stand_off_mm + optics_.depth_mm) {
          const auto pixel = static_cast<std::int64_t>(i);
          const Vec3 seen = optics_.on_plate(pixel % map_.width, pixel / map_.width, map_.width, map_.height);
          map_.points[i] = seen * (z / optics_.stand_off_mm);
        } else {
          map_.flaws[i] = Flaw::OutOfBand;
        }
      }
      if (map_.flaws[i] != Flaw::None) map_.wrapped[i] = map_.unwrapped[i] = kNaN;
    }
  }

  const Optics& optics_;
  std::span<const Shifted> gratings_;
  std::uint16_t white_;
  const Quality& quality_;
  RangeMap map_;
};

}  // namespace

std::span<const Field> Optics::fields() {
  using P = Optics;
  static const Field table[] = {
      field<P, &P::field_x_mm>("field_x_mm", "", "Width of the field at the plate.", {0, 1e6, true}),
      field<P, &P::field_y_mm>("field_y_mm", "", "Height of the field at the plate.", {0, 1e6, true}),
      field<P, &P::stand_off_mm>("stand_off_mm", "", "Distance of the reference plate from the camera.",
                                 {0, 1e6, true}),
      field<P, &P::depth_mm>("depth_mm", "", "Half the depth band about the plate.", {0, 1e6, true}),
      field<P, &P::baseline_mm>("baseline_mm", "", "Distance of the projector from the camera along +x.", {-1e6, 1e6}),
  };
  return table;
}

std::span<const Field> Quality::fields() {
  using P = Quality;
  static const Field table[] = {
      field<P, &P::min_visibility>("min_visibility", "", "Modulation over mean brightness that a pixel must have.",
                                   {0, 1}),
      field<P, &P::min_modulation>("min_modulation", "", "Modulation that a pixel must have, of white.", {0, 1}),
      field<P, &P::max_disagreement>("max_disagreement", "",
                                     "Turns by which a finer grating may miss what the coarser ones say.", {0, 0.5}),
  };
  return table;
}

std::uint64_t RangeMap::count(Flaw flaw) const {
  return static_cast<std::uint64_t>(std::count(flaws.begin(), flaws.end(), flaw));
}

Wave wave_of(std::span<const double> samples) { return Weights(samples.size()).wave(samples); }

Result<RangeMap> range_map(const Optics& optics, std::span<const Shifted> gratings, std::uint16_t white,
                           const Quality& quality) {
  for (const auto& problem : problems_of(Quality::fields(), &quality)) return fail(Code::BadParameter, problem);
  TRY(check(optics, gratings));
  if (optics.baseline_mm == 0)
    return fail(Code::BadParameter, "baseline_mm is 0: seen from the projector's place fringes do not move with depth");
  return Decoder(optics, gratings, white, quality).run();
}

}  // namespace scanmill::fringe
