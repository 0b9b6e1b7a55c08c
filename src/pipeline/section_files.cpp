// SPDX-License-Identifier: Apache-2.0
#include "pipeline/section_files.hpp"

#include <algorithm>
#include <functional>

#include "base/digest.hpp"
#include "export/comparing_sink.hpp"
#include "export/section_files.hpp"
#include "mesh/section_drawing.hpp"
#include "render/png.hpp"
#include "render/section.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr int kWidth = 960;  // pixels

using Writer = Result<void> (*)(std::span<const Section>, ByteSink&);

Result<WrittenFile> write_one(const std::vector<Section>& sections, Writer write, const std::string& folder,
                              const char* name) {
  const std::string path = folder + "/" + name;
  TRY_ASSIGN(auto sink, store::create_file(path));
  TRY(write(sections, *sink));
  TRY(sink->commit());
  TRY_ASSIGN(const auto source, store::open_file(path, path));
  exporting::ComparingSink same(*source);
  TRY(write(sections, same));
  TRY(same.commit());
  WrittenFile file;
  file.name = name;
  file.bytes = source->size();
  TRY_ASSIGN(file.sha256, sha256_of(*source));
  return file;
}

}  // namespace

Result<std::vector<WrittenFile>> write_section_files(const std::vector<Section>& sections,
                                                     const std::vector<Output>& outputs, const std::string& folder) {
  std::vector<WrittenFile> files;
  if (sections.empty()) return files;
  TRY_ASSIGN(WrittenFile sheet, write_one(sections, exporting::write_sections_svg, folder, "sections.svg"));
  TRY_ASSIGN(WrittenFile lines, write_one(sections, exporting::write_sections_dxf, folder, "sections.dxf"));
  files.push_back(std::move(sheet));
  files.push_back(std::move(lines));
  if (std::any_of(outputs.begin(), outputs.end(), [](const Output& output) { return output.format == "iges"; })) {
    TRY_ASSIGN(WrittenFile curves, write_one(sections, exporting::write_sections_iges, folder, "sections.igs"));
    files.push_back(std::move(curves));
  }
  return files;
}

Result<std::vector<report::SectionRow>> draw_sections(const std::vector<Section>& sections, const std::string& folder) {
  std::vector<report::SectionRow> rows;
  for (std::size_t n = 0; n < sections.size(); ++n) {
    const Section& section = sections[n];
    report::SectionRow& row = rows.emplace_back();
    row.name = section.frame.name;
    row.slab_mm = section.frame.slab_mm;
    row.length_mm = section.length_mm;
    row.points = section.points_in_slab;
    row.max_mm = section.max_mm;
    row.rms_mm = section.rms_mm;
    row.magnify = section.magnify;
    if (section.worst) {
      row.worst = section.worst->place;
      row.worst_signed_mm = section.worst->signed_mm;
    }
    TRY_ASSIGN(const render::Image image, render::render_section(section, kWidth));
    row.picture.width = image.width;
    row.picture.height = image.height;
    row.picture.caption = section.frame.name + ": " + section_figures(section);
    const std::string path = folder + "/section-" + std::to_string(n + 1) + ".png";
    const auto sink = memory_sink(path, row.picture.png);
    TRY(render::write_png(image, *sink));
    TRY(sink->commit());
    TRY(store::write_text(path, row.picture.png));
  }
  return rows;
}

}  // namespace scanmill::pipeline
