// SPDX-License-Identifier: Apache-2.0
#include "pipeline/replay_pictures.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "render/png.hpp"
#include "render/rig_picture.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

using render::Rgb;

constexpr Rgb kDeck{206, 200, 188}, kHead{88, 110, 150}, kPartBox{150, 186, 140}, kPartEdge{190, 200, 186},
    kArm{140, 144, 152};
constexpr Rgb kWay{214, 108, 24}, kRay{232, 170, 60}, kField{190, 60, 60}, kRange{120, 160, 120};
constexpr int kWidth = 1600, kHeight = 1240;

std::vector<Vec3> box_edges_path(const Pose& frame, Vec3 low, Vec3 high) {
  const auto at = [&](int k) {
    return frame.apply({k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z});
  };
  // One line over all twelve edges; four are passed twice.
  std::vector<Vec3> path;
  for (const int k : {0, 1, 3, 2, 0, 4, 5, 1, 5, 7, 3, 7, 6, 2, 6, 4}) path.push_back(at(k));
  return path;
}

class Scenes {
 public:
  explicit Scenes(const Rehearsal& r) : r_(r) {
    if (r.bins) points_ = r.bins->cloud.measured;
    for (const Vec3 p : points_) part_.add(p);
    if (r.plan.part) {
      part_.add(r.plan.part->low);
      part_.add(r.plan.part->high);
    }
    Bounds eyes = part_;
    for (const plan::Station& station : r.plan.stations) eyes.add(station.pose.translation);
    const Vec3 size = eyes.empty() ? Vec3{} : eyes.size();
    reach_ = r.plan.has_sensor ? r.plan.sensor.stand_off_mm : 0.2 * std::max({size.x, size.y, size.z, 1.0});
  }

  render::RigScene machine_scene() const {
    render::RigScene scene = common();
    scene.title = title("machine, way of the head, part");
    scene.caption = {"blocks: the head at each station", "orange: its way", "green lines: range of the joints"};
    if (r_.plan.machine) add_range(scene);
    const std::size_t n = r_.replay.steps.size();
    for (std::size_t s = 0; s < n; ++s) {
      add_head(scene, s, s == 0 || n <= 40);
      if (s == 0) add_arm(scene, r_.replay.steps[s]);
    }
    return scene;
  }

  render::RigScene part_scene() const {
    render::RigScene scene = common();
    scene.title = title("part, and where the head looks");
    scene.caption = {r_.plan.has_sensor ? "red: field at the stand-off" : "blocks: origins of the views",
                     points_.empty() ? "green block: the part" : "blue: points"};
    Bounds focus = part_;
    const std::size_t n = r_.replay.steps.size(), every = std::max<std::size_t>(1, n / 120);
    for (std::size_t s = 0; s < n; s += every) {
      const Pose& view = r_.plan.stations[s].pose;
      add_view(scene, view, true);
      focus.add(view.translation);
      scene.labels.push_back({view.translation, r_.plan.stations[s].name});
    }
    if (n > 40) scene.labels.clear();
    // The part stays recognisable when the head is far from it.
    if (!part_.empty() && !focus.empty()) {
      const Vec3 size = part_.size(), middle = part_.low + size * 0.5;
      const double most = 4 * std::max({size.x, size.y, size.z, reach_ * 0.5});
      focus.low = {std::max(focus.low.x, middle.x - most), std::max(focus.low.y, middle.y - most),
                   std::max(focus.low.z, middle.z - most)};
      focus.high = {std::min(focus.high.x, middle.x + most), std::min(focus.high.y, middle.y + most),
                    std::min(focus.high.z, middle.z + most)};
    }
    if (!focus.empty()) {  // room for the heads themselves and for names
      const Vec3 size = focus.size();
      const double room = 0.07 * std::max({size.x, size.y, size.z});
      focus.low = focus.low - Vec3{room, room, room};
      focus.high = focus.high + Vec3{room, room, room};
    }
    scene.focus = focus;
    return scene;
  }

 private:
  std::string title(const std::string& what) const {
    std::string name = r_.plan.name.empty() ? r_.path : r_.plan.name;
    if (r_.plan.machine && !r_.plan.machine->name.empty()) name += " on " + r_.plan.machine->name;
    return name + ": " + what + ", " + counted(r_.plan.stations.size(), "station");
  }

  /// Bodies as they stand at the first station, the way of the head, points.
  render::RigScene common() const {
    render::RigScene scene;
    scene.points = points_;
    if (r_.plan.machine) {
      const Pose deck = r_.plan.machine->part_frame.inverse();
      Pose machine;
      for (const plan::Step& step : r_.replay.steps)
        if (step.state.known) {
          machine = step.state.at.part.inverse();
          break;
        }
      for (const plan::KeepOut& body : r_.plan.machine->keep_out)
        scene.bodies.push_back({body.on == plan::Carries::Part ? deck : machine, body.box.low, body.box.high, kDeck});
    }
    if (r_.plan.part && points_.empty())
      scene.bodies.push_back({{}, r_.plan.part->low, r_.plan.part->high, kPartBox});
    else if (r_.plan.part)
      scene.lines.push_back({box_edges_path({}, r_.plan.part->low, r_.plan.part->high), kPartEdge, 1});
    std::vector<Vec3> way;
    for (const plan::Step& step : r_.replay.steps) way.insert(way.end(), step.path.begin(), step.path.end());
    scene.lines.push_back({std::move(way), kWay, 2});
    return scene;
  }

  /// The box that linear joints move the head through, at the angles of home, with the head's own place taken out.
  void add_range(render::RigScene& scene) const {
    const plan::Machine& machine = *r_.plan.machine;
    std::vector<double> joints;
    std::vector<std::size_t> linear;
    for (std::size_t i = 0; i < machine.joints.size(); ++i) {
      joints.push_back(machine.joints[i].home);
      if (machine.joints[i].type == plan::JointType::Linear && machine.joints[i].low) linear.push_back(i);
    }
    if (linear.empty() || linear.size() > 3) return;
    const auto mount_at = [&](std::size_t k) {
      std::vector<double> q = joints;
      for (std::size_t n = 0; n < linear.size(); ++n)
        q[linear[n]] = k >> n & 1 ? *machine.joints[linear[n]].high : *machine.joints[linear[n]].low;
      const plan::Placed at = plan::place(machine, plan::Mount{}, q);
      return at.view.translation;
    };
    for (std::size_t n = 0; n < linear.size(); ++n)
      for (std::size_t k = 0; k < std::size_t{1} << linear.size(); ++k)
        if ((k >> n & 1) == 0) scene.lines.push_back({{mount_at(k), mount_at(k | std::size_t{1} << n)}, kRange, 1.2});
  }

  /// Links from the last slide over the turning joints to the sensor at one station, as the part sees them.
  void add_arm(render::RigScene& scene, const plan::Step& step) const {
    if (!r_.plan.machine || !step.state.known) return;
    const Pose to_part = step.state.at.part.inverse();
    std::vector<Vec3> arm;
    const auto axes = plan::axes_at(*r_.plan.machine, step.state.joints);
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const plan::Joint& joint = r_.plan.machine->joints[i];
      if (joint.carries != plan::Carries::Sensor) continue;
      if (joint.type == plan::JointType::Linear) arm.clear();  // slides run on frames that the plan does not know
      arm.push_back(to_part.apply(axes[i].origin));
    }
    arm.push_back(step.state.at.view.translation);
    scene.lines.push_back({std::move(arm), kArm, 6});
  }

  void add_head(render::RigScene& scene, std::size_t s, bool with_view) const {
    const Pose& view = r_.plan.stations[s].pose;
    if (r_.plan.mount.body) {
      scene.bodies.push_back({view, r_.plan.mount.body->low, r_.plan.mount.body->high, kHead});
    } else {
      const double size = 0.12 * reach_;
      scene.bodies.push_back({view, {-size, -0.7 * size, -size}, {size, 0.7 * size, 0}, kHead});
    }
    if (with_view) add_view(scene, view, false);
  }

  /// Rays from the sensor to the corners of the field, and the field itself.
  void add_view(render::RigScene& scene, const Pose& view, bool with_glyph) const {
    if (with_glyph) {
      const double size = 0.04 * reach_;
      scene.bodies.push_back({view, {-size, -size, -1.6 * size}, {size, size, 0}, kHead});
    }
    if (!r_.plan.has_sensor) return;  // which way a view looked is not known then
    const scanmill::Sensor& sensor = r_.plan.sensor;
    const double half_x = sensor.field_x_mm / 2, half_y = sensor.field_y_mm / 2;
    std::vector<Vec3> field;
    for (const int k : {0, 1, 3, 2, 0}) {
      const Vec3 corner{k & 1 ? half_x : -half_x, k & 2 ? half_y : -half_y, reach_};
      field.push_back(view.apply(corner));
      if (k == 0 && field.size() > 1) continue;
      const Vec3 from = !sensor.perspective ? Vec3{corner.x, corner.y, 0} : Vec3{};
      scene.lines.push_back({{view.apply(from), field.back()}, kRay, 1});
    }
    scene.lines.push_back({std::move(field), kField, 1.4});
  }

  const Rehearsal& r_;
  std::vector<Vec3> points_;
  Bounds part_;
  double reach_ = 1;
};

Result<void> write_picture(const render::Image& image, const std::string& path) {
  TRY_ASSIGN(auto sink, store::create_file(path));
  TRY(render::write_png(image, *sink));
  return sink->commit();
}

/// Joint values over time, or over stations where no times are known.
Result<render::Image> timeline(const Rehearsal& r) {
  const plan::Machine& machine = *r.plan.machine;
  const bool timed = r.replay.totals.time_s.has_value();
  std::vector<render::TimelineLane> lanes;
  for (const plan::Joint& joint : machine.joints)
    lanes.push_back({joint.name + " [" + plan::unit_of(joint) + "]", {}, {}});
  std::vector<render::TimelineMark> marks;
  for (std::size_t s = 0; s < r.replay.steps.size(); ++s) {
    const plan::Step& step = r.replay.steps[s];
    if (!step.move) continue;
    constexpr int kPieces = 24;
    const double begin = timed ? *step.begin_s : static_cast<double>(s), way = timed ? *step.move->time_s : 1;
    for (int k = 0; k <= kPieces; ++k) {
      const double part = static_cast<double>(k) / kPieces;
      const std::vector<double> q = step.move->at_share(timed ? step.move->share_at(way * part) : part);
      for (std::size_t i = 0; i < lanes.size(); ++i) {
        lanes[i].at.push_back(begin + way * part);
        lanes[i].value.push_back(q[i]);
      }
    }
    marks.push_back({begin + way, r.plan.stations[s].name});
    for (std::size_t i = 0; timed && i < lanes.size(); ++i) {
      lanes[i].at.push_back(begin + *step.time_s);
      lanes[i].value.push_back(step.state.joints[i]);
    }
  }
  const std::string name =
      (r.plan.name.empty() ? r.path : r.plan.name) + ": joints " +
      (timed ? "over time, " + number_text(std::floor(*r.replay.totals.time_s * 10 + 0.5) / 10) + " s"
             : std::string("station by station"));
  const int height = static_cast<int>(std::clamp<std::size_t>(200 + 130 * lanes.size(), 240, 4000));
  return render::draw_timeline(lanes, marks, name, timed ? "seconds" : "stations", kWidth, height);
}

}  // namespace

Result<std::vector<std::string>> write_replay_pictures(const Rehearsal& r, const std::string& folder,
                                                       const Context& context, Progress& progress) {
  progress.stage("pictures", 0, 0);
  std::vector<std::string> names;
  if (r.plan.stations.empty()) return names;
  const Scenes scenes(r);
  const auto add = [&](Result<render::Image> image, const std::string& name) -> Result<void> {
    if (!image.ok()) return std::move(image).error();
    TRY(write_picture(*image, folder + "/" + name));
    names.push_back(name);
    return {};
  };
  TRY(add(render::draw_rig(scenes.machine_scene(), kWidth, kHeight, context), "machine.png"));
  TRY(add(render::draw_rig(scenes.part_scene(), kWidth, kHeight, context), "part.png"));
  if (r.plan.machine && !r.plan.machine->joints.empty()) TRY(add(timeline(r), "timeline.png"));
  return names;
}

}  // namespace scanmill::pipeline
