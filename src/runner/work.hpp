// SPDX-License-Identifier: Apache-2.0
// What the runner asks of the work it runs. The runner knows names, trees of keys and files, never geometry or formats;
// the command line binds this to the pipeline.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/progress.hpp"
#include "base/result.hpp"
#include "document/document.hpp"
#include "document/read_fields.hpp"

namespace scanmill::runner {

/// A scan of the archive.
struct ScanTask {
  std::string name;
  std::vector<std::string> notes;
  std::string broken;      // why it cannot be read at all; empty when fine
  bool is_of_job = false;  // described by the job itself, not by files of the archive
};

struct Archive {
  std::vector<ScanTask> scans;     // by name; their positions are the numbers used below
  std::vector<std::string> notes;  // of the archive as a whole
};

struct InputFile {
  std::string path;    // relative to the archive
  std::string sha256;  // empty for a missing file
  std::uint64_t bytes = 0;
};

/// Everything that decides the bytes of a scan's result; `value` is the digest of all of it.
struct Fingerprint {
  std::string value;
  std::string mesh;  // of all but the outputs and gates: equal ones make the same mesh
  std::vector<InputFile> inputs;
  std::vector<std::pair<std::string, std::string>> versions;  // stage, version
};

/// What a look at the names of a scan's files tells, without reading them.
struct InputLook {
  std::uint64_t bytes = 0;
  std::int64_t newest_ns = 0;  // the latest change of any of them, ns since 1970
};

struct Outcome {
  document::Node counts = document::Node::map();  // name -> number; `triangles` and `boundary_loops` are shown
  std::vector<std::string> notes;
  std::vector<std::string> failed_gates;  // one sentence each; the files stay, marked as rejected
  std::string record_identity;
  std::vector<std::pair<std::string, double>> stage_seconds, stage_cpu_seconds;  // cpu: of the process
};

/// A file of a scan's folder.
struct OutputFile {
  std::string name;
  std::uint64_t bytes = 0;
  std::string sha256;
};

/// How large scans are cut into tasks; changes no byte of a result.
struct BrickKeys {
  std::int64_t edge_bins = 0;  // of a brick; 0: 256, and only scans of many bytes are cut, where it brings something
  std::int64_t pieces = 0;     // of the input; 0: by its bytes
  std::int64_t batches = 0;    // of bricks; 0: by the bytes
  std::uint64_t cut_from = 0;  // bytes of input from which a scan is cut without an edge; 0: none is
};

/// On several machines a scan of so many bytes is made by all of them. On one it is made in one piece: what does not
/// fit into memory is paged to disk, which takes less of it than parts do.
inline constexpr std::uint64_t kCutFrom = 4ull << 30;

/// The parts of one scan: names by waves, each of which needs all before it, and where they are kept.
struct CutParts {
  std::vector<std::vector<std::string>> waves;  // empty: the scan is made in one piece
  std::vector<std::uint8_t> whole;              // per wave: its parts want as much memory as the scan
  std::string folder;
};

/// Seconds of stages or parts by name, in their order; cpu: of the processes.
struct StageSeconds {
  std::vector<std::pair<std::string, double>> wall, cpu;
};

/// What those parts will take. Per wave and, last, for the scan itself.
struct CutForecast {
  std::vector<std::uint64_t> disk;  // greatest sum of bytes of the parts that are there at one time
  std::vector<double> cpu;          // CPU time, of 1 for all
  std::uint64_t memory = 0;         // bytes that tasks which want the whole scan hold at their peak
  std::uint64_t bins = 0;           // occupied ones, about
};

/// What the page of a whole run is made from (runner/night.hpp).
struct Night {
  document::Node head;  // all but the scans
  std::size_t scans = 0;
  std::function<document::Node(std::size_t)> scan;  // one of them: not all are in memory at once
};

class Work {
 public:
  virtual ~Work() = default;
  virtual std::span<const std::string_view> what_keys() const = 0;
  /// Problems of a tree of what keys that need not be complete.
  virtual void check_part(const document::Node& part, document::Problems& problems) const = 0;
  virtual document::Node overlay(document::Node base, const document::Node& over) const = 0;
  /// Checks a complete tree and returns it with defaults filled in.
  virtual Result<document::Node> resolve(const document::Node& what, const std::string& name) const = 0;
  /// `what`: the job's keys without overrides; `what_for(scan)`: with those that match the scan's name.
  virtual Result<Archive> discover(const std::string& archive, const document::Node& what,
                                   const std::function<document::Node(const std::string& scan)>& what_for) = 0;
  virtual Result<Fingerprint> fingerprint(std::size_t scan, const document::Node& resolved) = 0;
  /// The same when no file must be read for it; nothing when a hash is not known, or a file cannot be looked at.
  virtual std::optional<Fingerprint> known_fingerprint(std::size_t scan, const document::Node& resolved) = 0;
  /// Files that are not there count nothing.
  virtual InputLook look_at(std::size_t scan) const = 0;
  /// Writes the scan's files, complete and synced, into the empty `folder`.
  virtual Result<Outcome> run(std::size_t scan, const document::Node& resolved, const std::string& folder,
                              const Context& context, Progress& progress) = 0;
  /// How the scan is cut, if it is: by its keys and bytes alone. `folder`: where its parts would be kept.
  virtual CutParts parts_of(std::size_t /*scan*/, const document::Node& /*resolved*/, const BrickKeys& /*keys*/,
                            const std::string& /*folder*/) const {
    return {};
  }
  /// Makes one part; nothing is done when it is there. `keys` and `folder` as for parts_of; the folder exists.
  virtual Result<void> make_part(std::size_t /*scan*/, const document::Node& /*resolved*/, const BrickKeys& /*keys*/,
                                 const std::string& /*folder*/, const std::string& part, const Context& /*context*/,
                                 Progress& /*progress*/) {
    return fail(Code::Internal, "this work has no parts", part);
  }
  /// Reads the scan's points once, unless the first part of the scan is there: it has the figures. Nothing: no
  /// forecast.
  virtual Result<std::optional<CutForecast>> forecast_parts(std::size_t /*scan*/, const document::Node& /*resolved*/,
                                                            const BrickKeys& /*keys*/, const std::string& /*folder*/,
                                                            const Context& /*context*/, Progress& /*progress*/) {
    return std::optional<CutForecast>();
  }
  /// The next run() of this scan puts it together from its parts, and makes those that are missing. What the parts
  /// took stands before its own stages.
  virtual void use_parts(std::size_t /*scan*/, const BrickKeys& /*keys*/, const std::string& /*folder*/,
                         const StageSeconds& /*took*/) {}
  /// The same files from an earlier result with the same Fingerprint::mesh that lies in `standing`, when only outputs
  /// or gates changed. Nothing when the earlier files cannot serve: `refusal` says why, and `folder` is still empty.
  virtual Result<std::optional<Outcome>> rewrite(std::size_t /*scan*/, const document::Node& /*resolved*/,
                                                 const std::string& /*standing*/,
                                                 const std::vector<OutputFile>& /*files*/,
                                                 const std::string& /*folder*/, const Context& /*context*/,
                                                 Progress& /*progress*/, std::string& refusal) {
    refusal = "this work cannot do so";
    return std::optional<Outcome>();
  }
  /// Known content hashes, kept between runs.
  virtual void load_hashes(std::string_view text) = 0;
  virtual std::string save_hashes() const = 0;
  /// Those of one scan's files, for load_hashes of another process.
  virtual std::string save_hashes_of(std::size_t scan) const = 0;
  /// The page of a whole run. Empty: this work has none.
  virtual std::string night_page(const Night& /*night*/) const { return {}; }
};

}  // namespace scanmill::runner
