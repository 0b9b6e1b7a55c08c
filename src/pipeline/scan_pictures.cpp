// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_pictures.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "render/render.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::int64_t kWidth = 640, kHeight = 480;
constexpr std::uint64_t kMostBytes = 64 << 20;

struct Kind {
  const char* word;  // in the job; empty: not asked for there
  const char* file;
  const char* caption;
  render::Style style;
};
/// In the order of the report; the last only where clean rules took points.
constexpr Kind kShaded{"shaded", "preview-shaded.png", "shaded, isometric; inside orange, open edges red",
                       render::Style::Shaded};
constexpr Kind kError{"error", "preview-error.png", "fit error of each vertex's bin, isometric", render::Style::Error};
constexpr Kind kPatches{"patches", "preview-patches.png", "patches with their seeds, isometric",
                        render::Style::Patches};
constexpr Kind kRemoved{"", "preview-removed.png", "what was kept, and in red what the clean rules removed",
                        render::Style::Points};
constexpr const Kind* kKinds[] = {&kShaded, &kError, &kPatches, &kRemoved};

/// Without its bytes yet.
report::Picture framed(const Kind& kind) {
  return {{}, kind.caption, static_cast<int>(kWidth), static_cast<int>(kHeight), &kind == &kShaded};
}

Result<report::Picture> draw(const render::Scene& scene, const Kind& kind, const std::string& folder,
                             const Context& context) {
  const std::string path = folder + "/" + kind.file;
  render::PictureParams params;
  params.style = kind.style;
  params.width = kWidth;
  params.height = kHeight;
  TRY_ASSIGN(const render::Image image, render::render(scene, params, context));
  report::Picture picture = framed(kind);
  const auto sink = memory_sink(path, picture.png);
  TRY(render::write_png(image, *sink));
  TRY(sink->commit());
  TRY(store::write_text(path, picture.png));
  return picture;
}

bool is_wanted(const Kind& kind, const What& what) {
  return *kind.word == '\0' || std::find(what.previews.begin(), what.previews.end(), kind.word) != what.previews.end();
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
  auto add = [&](const render::Scene& scene, const Kind& kind) -> Result<void> {
    TRY_ASSIGN(report::Picture picture, draw(scene, kind, folder, context));
    pictures.push_back(std::move(picture));
    return {};
  };
  render::Scene scene;
  scene.mesh = &mesh;
  scene.vertex_error = errors;
  scene.seeds = seeds;
  for (const Kind* kind : {&kShaded, &kError, &kPatches})
    if (is_wanted(*kind, results.what)) TRY(add(scene, *kind));
  if (!results.cleaned.cleaned) return pictures;
  std::vector<Vec3> removed;
  for (const clean::RemovedPoint& point : results.cleaned.cleaned->removed_sample()) removed.push_back(point.position);
  if (removed.empty()) return pictures;
  render::Scene points;
  points.mesh = &mesh;
  points.removed = removed;
  points.removed_of = results.cleaned.cleaned->counts().removed();
  TRY(add(points, kRemoved));
  return pictures;
}

bool is_picture(std::string_view name) {
  return std::any_of(std::begin(kKinds), std::end(kKinds), [&](const Kind* kind) { return kind->file == name; });
}

std::string picture_missing(const Previous& previous, const What& what) {
  for (const Kind* kind : kKinds)
    if (*kind->word != '\0' && is_wanted(*kind, what) && !previous.find(kind->file)) return kind->file;
  return {};
}

Result<std::vector<report::Picture>> copy_pictures(const Previous& previous, const What& what,
                                                   const std::string& folder) {
  std::vector<report::Picture> pictures;
  for (const Kind* kind : kKinds) {
    if (!is_wanted(*kind, what) || !previous.find(kind->file)) continue;
    const std::string path = previous.folder + "/" + kind->file;
    TRY_ASSIGN(const auto source, store::open_file(path, path));
    report::Picture& picture = pictures.emplace_back(framed(*kind));
    TRY_ASSIGN(picture.png, read_all(*source, kMostBytes));
    TRY(store::write_text(folder + "/" + kind->file, picture.png));
  }
  return pictures;
}

}  // namespace scanmill::pipeline
