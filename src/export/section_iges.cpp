// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>

#include "base/text.hpp"
#include "export/iges_curves.hpp"
#include "export/iges_lines.hpp"
#include "export/patch_colours.hpp"
#include "export/section_files.hpp"
#include "mesh/section_drawing.hpp"

namespace scanmill::exporting {
namespace {

constexpr double kResolution = 1e-6;  // mm

/// Lines that are more than a place.
bool is_drawn(const SectionLine& line) { return line.points.size() > 1; }

struct SectionPlan {
  std::span<const Section> sections;
  std::vector<std::uint64_t> first;  // curve of each section, and one behind the last
  std::uint64_t colour(std::size_t n) const { return n; }
  std::uint64_t name(std::size_t n) const { return sections.size() + n; }
  std::uint64_t curve(std::uint64_t k) const { return 2 * sections.size() + k; }
  IgesEntry entry(int type, int form, std::string_view status, std::size_t n) const {
    const auto number = static_cast<std::int64_t>(n) + 1;
    return {type,      form,  status, number, -static_cast<std::int64_t>(iges_directory_number(colour(n))),
            "SECTION", number};
  }
};

template <class Out>
Result<void> emit_curves(const SectionPlan& plan, Out& out, std::size_t n) {
  const Section& section = plan.sections[n];
  for (const SectionLine& line : section.lines) {
    if (!is_drawn(line)) continue;
    Result<void> done;
    out.entity(plan.entry(126, 0, kIgesMember, n), [&](auto& record) {
      put_polyline(
          record, line.points.size(), line.closed, section.frame.normal,
          [&](std::size_t k) {
            const Vec3 p = section.frame.place(line.points[k]);
            for (const double c : {p.x, p.y, p.z}) record.real(iges_real(c));
          },
          [&] {
            if (done.ok()) done = out.flush_when_full();
          });
    });
    TRY(done);
  }
  return {};
}

template <class Out>
Result<void> emit_group(const SectionPlan& plan, Out& out, std::size_t n) {
  Result<void> done;
  out.entity(plan.entry(402, 7, kIgesRoot, n), [&](auto& record) {
    record.integer(402);
    record.integer(static_cast<std::int64_t>(plan.first[n + 1] - plan.first[n]));
    for (std::uint64_t k = plan.first[n]; k < plan.first[n + 1]; ++k) {
      record.pointer(plan.curve(k));
      if (done.ok()) done = out.flush_when_full();
    }
    record.integer(0);
    record.integer(1);
    record.pointer(plan.name(n));
  });
  return done;
}

template <class Out>
Result<void> emit(const SectionPlan& plan, Out& out) {
  const std::size_t count = plan.sections.size();
  for (std::uint32_t n = 0; n < count; ++n)
    out.entity({314, 0, "00000200", 0, n % 7 + 2, "COLOUR", n + 1}, [&](auto& record) {
      record.integer(314);
      for (const double share : patch_colour_shares(n)) record.real(iges_fixed(100 * share, 3));
    });
  for (std::size_t n = 0; n < count; ++n)
    out.entity({406, 15, "00020300", 0, 0, "NAME", static_cast<std::int64_t>(n) + 1}, [&](auto& record) {
      record.integer(406);
      record.integer(1);
      record.text(iges_hollerith("section_" + std::to_string(n + 1)));
    });
  for (std::size_t n = 0; n < count; ++n) TRY(emit_curves(plan, out, n));
  for (std::size_t n = 0; n < count; ++n) TRY(emit_group(plan, out, n));
  return {};
}

double largest_coordinate(std::span<const Section> sections) {
  double largest = 0;
  for (const Section& section : sections)
    for (const SectionLine& line : section.lines)
      for (const Uv& at : line.points) {
        const Vec3 p = section.frame.place(at);
        largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      }
  return largest;
}

}  // namespace

Result<void> write_sections_iges(std::span<const Section> sections, ByteSink& sink) {
  SectionPlan plan{sections, {0}};
  for (const Section& section : sections)
    plan.first.push_back(plan.first.back() + static_cast<std::uint64_t>(
                                                 std::count_if(section.lines.begin(), section.lines.end(), is_drawn)));
  IgesCounter counter;
  TRY(emit(plan, counter));
  TextBuffer out(sink);
  IgesHeader start(out, 'S'), global(out, 'G');
  start.free_text("scanmill sections, units mm");
  for (std::size_t n = 0; n < sections.size(); ++n)
    start.free_text("section_" + std::to_string(n + 1) + ": " + sections[n].frame.name);
  put_iges_global(global, "sections", kResolution, largest_coordinate(sections));
  IgesDirectory directory(out, counter.lines());
  TRY(emit(plan, directory));
  IgesParameters parameters(out);
  TRY(emit(plan, parameters));
  put_iges_terminate(out, start.lines(), global.lines(), 2 * counter.lines().size(), counter.total());
  return out.flush();
}

}  // namespace scanmill::exporting
