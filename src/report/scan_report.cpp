// SPDX-License-Identifier: Apache-2.0
// The order of the page: the verdict and the few numbers that matter, pictures, then tables.
#include "report/scan_report.hpp"

#include "report/html.hpp"
#include "report/sections.hpp"
#include "report/style.hpp"

namespace scanmill::report {
namespace {

void add_head(const ScanReport& report, std::string& out) {
  const std::string name = report.scan.empty() ? "scan" : report.scan;
  const std::string title = report.title.empty() ? name + (report.job.empty() ? "" : ": " + report.job) : report.title;
  out +=
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
      // Even a hole in the escaping would fetch and run nothing.
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'unsafe-inline'\"/>\n<title>" +
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
  link(!report.pictures.empty(), "pictures", "Pictures");
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

void add_picture(const Picture& picture, std::string& out) {
  const std::string caption = escaped(picture.caption);
  out += "<figure><img alt=\"" + caption + "\"";
  if (picture.width > 0 && picture.height > 0)
    out += " width=\"" + std::to_string(picture.width) + "\" height=\"" + std::to_string(picture.height) + "\"";
  out +=
      " src=\"data:image/png;base64," + base64(picture.png) + "\"/><figcaption>" + caption + "</figcaption></figure>\n";
}

}  // namespace

Result<void> write_scan_report(const ScanReport& report, ByteSink& sink) {
  std::string out;
  const auto flush = [&]() -> Result<void> {
    TRY(sink.write(std::string_view(out)));
    out.clear();
    return {};
  };
  add_head(report, out);
  add_verdict(report, out);
  add_tiles(report, out);
  add_notes(report, out);
  add_navigation(report, out);
  out += "</header>\n<main>\n";
  if (!report.pictures.empty()) {
    add_heading(out, "pictures", "Pictures");
    out += "<div class=\"pictures\">\n";
    for (const Picture& picture : report.pictures) {
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
  out += "</body>\n</html>\n";
  return flush();
}

}  // namespace scanmill::report
