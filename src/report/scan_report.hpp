// SPDX-License-Identifier: Apache-2.0
// The page a lab reads after a scan: report.html, plain data in, bytes out.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "geom/vec3.hpp"

namespace scanmill::report {

// All lengths in mm, all places in the global frame, all text UTF-8 and not yet escaped. What is not known stays empty
// and its row or section is left out; nothing is shown as zero that was not counted.

/// A limit of the job and what was found.
struct Gate {
  std::string key;  // "verify.max_error_mm"
  double limit = 0, found = 0;
  std::string unit = "mm";
  bool passed = true;
};

/// A PNG in full.
struct Picture {
  std::string png;
  std::string caption;           // "fit error, seen from +x"
  int width = 0, height = 0;     // pixels, so that the page does not jump; 0 when not known
  bool stands_for_view = false;  // what is seen where the 3-D view is not: no script, no WebGL, paper
};

/// The mesh as a reader of the page may turn it. Colours are those of the pictures.
struct SurfaceView {
  using Colour = std::array<std::uint8_t, 3>;
  std::vector<Vec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;              // outward counter-clockwise
  std::vector<std::uint32_t> patch;                                 // per triangle
  std::vector<double> errors;                                       // per vertex, mm; NaN where none is known
  std::vector<std::pair<std::uint32_t, std::uint32_t>> open_edges;  // of vertices
  std::vector<Colour> patch_colours;                                // of patch n: number n modulo their count
  std::vector<Colour> error_colours;                                // of kErrorColours codes
  double error_range_mm = 0;                                        // both ends of the scale
  Colour front{}, back{}, open{};                                   // shaded: outside, inside; open edges
  std::uint64_t full_triangles = 0;                                 // of the mesh itself
  double cell_mm = 0;                                               // of the grid that made it coarser; 0: it is whole
};
/// Codes of an error on the page: unknown, below the scale, 253 steps over it, above.
inline constexpr std::size_t kErrorColours = 256;
/// Where a code's error lies on the scale: 2 .. 254 from -1 to 1, 1 and 255 beyond.
inline constexpr double error_of_code(std::size_t code) { return (static_cast<double>(code) - 128) / 126; }

/// Points or bins that went, by reason, in the order in which the reasons apply.
struct Dropped {
  std::string reason;  // "not finite", "remove_plane", "c2"
  std::uint64_t count = 0;
};

struct Points {
  std::uint64_t read = 0, used = 0;
  std::vector<Dropped> dropped;
  std::optional<std::uint64_t> meshed = {};  // of the used ones: within one bin edge of a triangle
  bool meshed_is_low = false;                // shown as a fault
};

struct Reduction {
  double bin_mm = 0;
  std::uint64_t bins = 0, kept = 0;  // occupied bins; points that may become vertices
  std::vector<Dropped> thinned;      // bins whose point was not kept
};

/// A piece of surface that was left out of the mesh.
struct Component {
  std::uint64_t triangles = 0, vertices = 0;
  Vec3 centre, size;
};

struct Loop {
  double length_mm = 0;
  std::uint64_t edges = 0;
  Vec3 centre;
};

/// Two triangles that meet outside their shared vertices and edges.
struct Crossing {
  std::uint64_t first = 0, second = 0;  // triangle numbers
  Vec3 place;
  std::string cause;  // may be empty
};

struct Mesh {
  std::uint64_t vertices = 0, triangles = 0, patches = 0, components = 0, boundary_edges = 0;
  std::int64_t euler = 0;
  // Zero on a sound mesh.
  std::uint64_t nonmanifold_edges = 0, nonmanifold_vertices = 0, misoriented_edges = 0, degenerate_triangles = 0;
  std::optional<std::uint64_t> crossings;                           // pairs; empty: not looked for
  std::vector<Crossing> crossing_places;                            // as many as are known
  std::vector<Loop> loops;                                          // any order; shown longest first
  std::vector<Component> dropped;                                   // stray components
  std::optional<double> smallest_angle_deg, smallest_angle_p5_deg;  // least of all; 5th percentile over triangles
  std::optional<double> g2_deg;
  std::optional<double> mean_edge_mm, longest_edge_mm, g1_mm;
  std::optional<double> area_mm2, volume_mm3;  // volume of closed surfaces only

  std::uint64_t faults() const {
    return nonmanifold_edges + nonmanifold_vertices + misoriented_edges + degenerate_triangles + crossings.value_or(0);
  }
};

/// Distances of a class of input points from the mesh.
struct Distances {
  std::uint64_t count = 0;
  double max_mm = 0, rms_mm = 0, mean_mm = 0, signed_mean_mm = 0;  // of unsigned distances, but for the last
  double above_mm = 0, below_mm = 0;                               // greatest on the normal's side and on the other
  std::optional<double> p50_mm, p90_mm, p95_mm, p99_mm, p999_mm;
};

struct PatchRow {
  std::uint64_t number = 0;
  std::string name;    // may be empty
  std::string origin;  // of its seed: "given", "automatic", "component"
  Vec3 seed;
  std::uint64_t triangles = 0;
  double area_mm2 = 0;
  std::optional<Distances> distances;
};

/// Counts by signed distance: counts[n] holds [low + n step, low + (n + 1) step).
struct Histogram {
  double low_mm = 0, step_mm = 0;
  std::vector<std::uint64_t> counts;
  std::uint64_t below = 0, above = 0;  // outside
};

struct WorstPoint {
  Vec3 place;
  double signed_mm = 0;
  std::string file;
  std::uint64_t row = 0;
  std::string row_meaning;  // "line", "vertex"
  std::uint64_t patch = 0;
  bool open_border = false;  // its nearest place lies on an open edge
};

struct Fit {
  Distances all, interior, open_border, patch_borders;
  Histogram histogram;
  std::vector<WorstPoint> worst, worst_interior;  // greatest first
  double fit_error_mm = 0;                        // the greatest distance
  std::optional<double> sensor_accuracy_mm;       // stated apart; their sum is shown with it
  std::optional<double> coverage;                 // share of the triangles that an input point lies near, 0 .. 1
};

struct Creases {
  double dihedral_sum_deg = 0, normal_variation_rms = 0, sharp_length_mm = 0;
  std::uint64_t sharp_edges = 0;
};

/// One pass of edge swaps.
struct Swaps {
  std::string pass;  // "smooth", "feature"
  std::uint64_t rounds = 0, swaps = 0;
  std::optional<double> angle_p5_before_deg, angle_p5_after_deg;
};

/// A plane cut through mesh and points, with its picture.
struct SectionRow {
  std::string name;
  double slab_mm = 0, length_mm = 0;
  std::uint64_t points = 0;
  double max_mm = 0, rms_mm = 0, magnify = 1;
  std::optional<Vec3> worst;
  double worst_signed_mm = 0;
  Picture picture;
};

/// A *what* key in force.
struct Parameter {
  std::string key, symbol;  // "reduce.min_neighbour_distance", "c2" or empty
  std::string value, unit;  // unit may be empty
  std::string default_value;
  bool changed = false;
};

struct InputFile {
  std::string path, format;
  std::uint64_t bytes = 0, points_read = 0, points_used = 0;
  std::string sha256;
  bool missing = false;
};

struct OutputFile {
  std::string path;
  std::uint64_t bytes = 0;
  std::string sha256;
};

struct Note {
  bool warning = false;
  std::string text;
};

struct ScanReport {
  std::string title;  // of the page; "scan: job" when empty
  std::string scan, job;
  std::string tool;    // "scanmill 0.1.0"
  std::string record;  // identity of the record
  std::vector<Gate> gates;
  std::vector<Note> notes;
  std::vector<Picture> pictures;
  std::optional<SurfaceView> view;
  Points points;
  std::optional<Reduction> reduction;
  Mesh mesh;
  std::optional<Fit> fit;
  std::vector<PatchRow> patches;
  std::vector<SectionRow> sections;
  std::vector<Swaps> swaps;
  std::optional<Creases> creases_before, creases_after;  // the feature pass
  std::vector<Parameter> parameters;
  std::vector<InputFile> inputs;
  std::vector<OutputFile> outputs;
  std::vector<std::pair<std::string, std::string>> stage_versions;  // name, version
  // What differs from run to run stands on one line of the file, the one that begins with kRunLine.
  std::string date;                                           // as it is to be read; may be empty
  std::vector<std::pair<std::string, double>> stage_seconds;  // wall, in order
};

/// How the only line begins that depends on when and where the page was made. Absent without date and times.
inline constexpr char kRunLine[] = "<p id=\"run\">";
inline constexpr std::size_t kLoopsShown = 50, kPatchesShown = 200, kComponentsShown = 50;

/// Everything in one UTF-8 file: pictures as data URIs, style inline, nothing fetched; the only script is that of the
/// 3-D view, which the page's policy names by its digest. All text is escaped; control characters, bytes that are no
/// UTF-8 and marks that turn the direction of writing are shown by number. The view takes about 14 bytes a triangle.
/// Does not commit the sink. The same report gives the same bytes.
/// errors  what the sink reports; Internal when lists of the view differ in length or name a vertex that does not exist
Result<void> write_scan_report(const ScanReport& report, ByteSink& sink);

}  // namespace scanmill::report
