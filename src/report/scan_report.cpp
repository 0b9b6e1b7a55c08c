// SPDX-License-Identifier: Apache-2.0
// The order of the page: the verdict and the few numbers that matter, pictures, then tables.
#include "report/scan_report.hpp"

#include <algorithm>

#include "base/digest.hpp"
#include "report/html.hpp"
#include "report/sections.hpp"
#include "report/style.hpp"
#include "report/view_script.hpp"

namespace scanmill::report {
namespace {

std::string script_digest() {
  const std::string digits = sha256_hex(kViewScript);
  const auto value = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::string bytes;
  for (std::size_t n = 0; n < digits.size(); n += 2)
    bytes += static_cast<char>(value(digits[n]) * 16 + value(digits[n + 1]));
  return base64(bytes);
}

/// The picture that the view replaces; null where there is none.
const Picture* stand_in(const ScanReport& report) {
  const auto& list = report.pictures;
  const auto at = std::find_if(list.begin(), list.end(), [](const Picture& p) { return p.stands_for_view; });
  return report.view && at != list.end() ? &*at : nullptr;
}

bool has_pictures(const ScanReport& report) { return report.pictures.size() > (stand_in(report) ? 1u : 0u); }

Result<void> check(const SurfaceView& view) {
  const std::size_t vertices = view.positions.size();
  bool sound = (view.patch.empty() || view.patch.size() == view.triangles.size()) &&
               (view.errors.empty() || view.errors.size() == vertices);
  for (const auto& x : view.triangles) sound = sound && x[0] < vertices && x[1] < vertices && x[2] < vertices;
  for (const auto& [a, b] : view.open_edges) sound = sound && a < vertices && b < vertices;
  if (!sound) return fail(Code::Internal, "the lists of the report's 3-D view do not belong together");
  return {};
}

void add_head(const ScanReport& report, std::string& out) {
  const std::string name = report.scan.empty() ? "scan" : report.scan;
  const std::string title = report.title.empty() ? name + (report.job.empty() ? "" : ": " + report.job) : report.title;
  out +=
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      // Even a hole in the escaping would fetch nothing, and run nothing but the script of the view.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'unsafe-inline'" +
      (report.view ? "; script-src 'sha256-" + script_digest() + "'" : std::string()) + "\"/>\n<title>" +
      escaped(title) + "</title>\n<style>" + kStyleSheet + "</style>\n</head>\n<body>\n<header>\n<h1>" + escaped(name) +
      "</h1>\n";
  const bool own_title = !report.title.empty() && report.title != name;
  if (own_title || !report.job.empty())
    out += "<p class=\"sub\">" + escaped(own_title ? report.title : "") +
           (own_title && !report.job.empty() ? " \xc2\xb7 " : "") +
           (report.job.empty() ? "" : "job " + escaped(report.job)) + "</p>\n";
}

void add_navigation(const ScanReport& report, std::string& out) {
  out += "<nav aria-label=\"on this page\">";
  const auto link = [&](bool there, const char* id, const char* name) {
    if (there) out += std::string("<a href=\"#") + id + "\">" + name + "</a> ";
  };
  link(report.view.has_value(), "view", "3-D view");
  link(has_pictures(report), "pictures", "Pictures");
  link(!report.gates.empty(), "gates", "Gates");
  link(report.fit.has_value(), "fit", "Fit error");
  link(!report.sections.empty(), "sections", "Sections");
  link(true, "points", "Points");
  link(true, "mesh", "Mesh");
  link(true, "loops", "Open loops");
  link(!report.patches.empty(), "patches", "Patches");
  link(!report.parameters.empty(), "parameters", "Parameters");
  link(!report.inputs.empty() || !report.outputs.empty(), "files", "Files");
  out += "</nav>\n";
}

}  // namespace

void add_picture(const Picture& picture, std::string& out) {
  const std::string caption = escaped(picture.caption);
  out += "<figure><img alt=\"" + caption + "\"";
  if (picture.width > 0 && picture.height > 0)
    out += " width=\"" + std::to_string(picture.width) + "\" height=\"" + std::to_string(picture.height) + "\"";
  out +=
      " src=\"data:image/png;base64," + base64(picture.png) + "\"/><figcaption>" + caption + "</figcaption></figure>\n";
}

Result<void> write_scan_report(const ScanReport& report, ByteSink& sink) {
  std::string out;
  const auto flush = [&]() -> Result<void> {
    TRY(sink.write(std::string_view(out)));
    out.clear();
    return {};
  };
  if (report.view) TRY(check(*report.view));
  add_head(report, out);
  add_verdict(report, out);
  add_tiles(report, out);
  add_notes(report, out);
  add_navigation(report, out);
  out += "</header>\n<main>\n";
  const Picture* const shown_by_view = stand_in(report);
  if (report.view) add_view(*report.view, shown_by_view, out);
  if (has_pictures(report)) {
    add_heading(out, "pictures", "Pictures");
    out += "<div class=\"pictures\">\n";
    for (const Picture& picture : report.pictures) {
      if (&picture == shown_by_view) continue;
      add_picture(picture, out);
      TRY(flush());  // pictures are the bulk of the page: never all of them twice in memory
    }
    out += "</div>\n";
  }
  add_gates(report, out);
  add_fit(report, out);
  add_section_rows(report, out);
  for (const SectionRow& section : report.sections) {
    add_picture(section.picture, out);
    TRY(flush());
  }
  add_points(report, out);
  add_mesh(report, out);
  add_loops(report, out);
  add_patches(report, out);
  add_swaps(report, out);
  add_parameters(report, out);
  add_files(report, out);
  out += "</main>\n";
  add_footer(report, out);
  TRY(flush());
  if (report.view) add_view_script(*report.view, out);  // last: all above is read while this is still loading
  out += "</body>\n</html>\n";
  return flush();
}

}  // namespace scanmill::report
