// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_pictures.hpp"

#include <limits>

#include "render/render.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::int64_t kWidth = 640, kHeight = 480;

Result<report::Picture> draw(const render::Scene& scene, render::Style style, const std::string& caption,
                             const std::string& path, const Context& context) {
  render::PictureParams params;
  params.style = style;
  params.width = kWidth;
  params.height = kHeight;
  TRY_ASSIGN(const render::Image image, render::render(scene, params, context));
  report::Picture picture{{}, caption, static_cast<int>(kWidth), static_cast<int>(kHeight)};
  const auto sink = memory_sink(path, picture.png);
  TRY(render::write_png(image, *sink));
  TRY(sink->commit());
  TRY(store::write_text(path, picture.png));
  return picture;
}

}  // namespace

Result<std::vector<report::Picture>> write_pictures(const ScanResults& results, const std::string& folder,
                                                    const Context& context, Progress& progress) {
  progress.stage("pictures", 0, 0);
  const Mesh& mesh = results.surface.mesh;
  std::vector<double> errors;
  for (const verify::VertexError& error : results.fit.vertices)
    errors.push_back(error.points > 0 ? error.signed_mm : std::numeric_limits<double>::quiet_NaN());
  std::vector<Vec3> seeds;
  for (const grow::Patch& patch : results.surface.patches.patches) seeds.push_back(patch.seed);
  std::vector<report::Picture> pictures;
  auto add = [&](const render::Scene& scene, render::Style style, const char* name,
                 const char* caption) -> Result<void> {
    TRY_ASSIGN(report::Picture picture, draw(scene, style, caption, folder + "/preview-" + name + ".png", context));
    pictures.push_back(std::move(picture));
    return {};
  };
  render::Scene scene;
  scene.mesh = &mesh;
  scene.vertex_error = errors;
  scene.seeds = seeds;
  TRY(add(scene, render::Style::Shaded, "shaded", "shaded, isometric; inside orange, open edges red"));
  TRY(add(scene, render::Style::Error, "error", "fit error of each vertex's bin, isometric"));
  TRY(add(scene, render::Style::Patches, "patches", "patches with their seeds, isometric"));
  if (!results.cleaned.cleaned) return pictures;
  std::vector<Vec3> removed;
  for (const clean::RemovedPoint& point : results.cleaned.cleaned->removed_sample()) removed.push_back(point.position);
  if (removed.empty()) return pictures;
  render::Scene points;
  points.mesh = &mesh;
  points.removed = removed;
  points.removed_of = results.cleaned.cleaned->counts().removed();
  TRY(add(points, render::Style::Points, "removed", "what was kept, and in red what the clean rules removed"));
  return pictures;
}

}  // namespace scanmill::pipeline
