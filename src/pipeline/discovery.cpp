// SPDX-License-Identifier: Apache-2.0
#include "pipeline/discovery.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/text.hpp"
#include "document/document.hpp"
#include "formats/conf.hpp"
#include "formats/poses.hpp"
#include "formats/probe.hpp"
#include "pipeline/plan_scan.hpp"
#include "pipeline/scan_names.hpp"
#include "store/files.hpp"

namespace scanmill::pipeline {
namespace {

constexpr std::uint64_t kMaxPlan = 64 << 20, kMaxConf = 16 << 20;
constexpr std::size_t kLook = 1 << 16;

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

bool begins_line(const std::string& text, const std::string& word) {
  return text.starts_with(word) || text.find("\n" + word) != std::string::npos;
}

/// The path stands in the text and is not the end or the beginning of another.
bool names(const std::string& text, const std::string& path) {
  const auto in_path = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '-' ||
           c == '.' || c == '/' || static_cast<unsigned char>(c) >= 0x80;
  };
  for (auto at = text.find(path); at != std::string::npos; at = text.find(path, at + 1)) {
    std::size_t begin = at;
    if (begin >= 2 && text.compare(begin - 2, 2, "./") == 0) begin -= 2;
    const std::size_t end = at + path.size();
    if ((begin == 0 || !in_path(text[begin - 1])) && (end == text.size() || !in_path(text[end]))) return true;
  }
  return false;
}

class Finder {
 public:
  Finder(const std::string& archive, const DiscoveryKeys& keys, const std::vector<std::string>& files)
      : archive_(archive), keys_(keys), files_(files), present_(files.begin(), files.end()) {}

  Result<Discovery> run() {
    for (const ViewsSpec& spec : keys_.views) take_views(spec);
    for (const std::string& file : files_)
      if (!claimed_.contains(file)) TRY(look_for_description(file));
    for (const std::string& file : files_)
      if (!claimed_.contains(file)) TRY(look_for_points(file));
    TRY(name_scans());
    for (const auto& [what, group] : groups_)
      found_.notes.push_back(std::to_string(group.count) + (group.count == 1 ? " file " : " files ") + what +
                             (group.count == 1 ? ": " : ", the first is ") + group.first);
    return std::move(found_);
  }

 private:
  struct Group {
    std::size_t count = 0;
    std::string first;
  };

  Result<std::shared_ptr<const ByteSource>> open(const std::string& file) const {
    return store::open_file(archive_ + "/" + file, file);
  }
  void note(const std::string& what, const std::string& file) {
    Group& group = groups_[what];
    if (group.count++ == 0) group.first = file;
  }

  /// One file that cannot be read does not hide the others.
  Result<void> note_unreadable(const Error& error, const std::string& file) {
    note("that may describe a scan not readable (" + error.message + ")", file);
    return {};
  }

  void take_views(const ViewsSpec& spec) {
    Result<std::vector<formats::NamedPose>> poses = std::vector<formats::NamedPose>();
    if (!spec.poses.empty()) {
      const auto source = open(spec.poses);
      poses = source.ok() ? formats::read_poses(**source) : Result<std::vector<formats::NamedPose>>(source.error());
      claimed_.insert(spec.poses);
    }
    std::vector<std::string> matched;
    ScanSpec scan = scan_of_views(spec, files_, poses, matched);
    claimed_.insert(matched.begin(), matched.end());
    by_hand_.push_back(std::move(scan));
  }

  Result<void> look_for_description(const std::string& file) {
    const std::string suffix = formats::suffix_of(file);
    if (suffix == "conf" || suffix == "aln") return look_at_conf(file, suffix == "aln");
    if (suffix == "yaml" || suffix == "yml" || suffix == "json") return look_at_document(file);
    return {};
  }

  Result<void> look_at_conf(const std::string& file, bool is_aln) {
    const auto source = open(file);
    if (!source.ok()) return note_unreadable(source.error(), file);
    const auto conf = is_aln ? Result<bool>(true) : formats::is_conf(**source);
    if (!conf.ok()) return note_unreadable(conf.error(), file);
    const auto text = read_all(**source, kMaxConf);
    const std::vector<std::string> named = text.ok() ? files_named_in(*text, file) : std::vector<std::string>();
    // A list of views whose every "bmesh" is misspelt names its files all the same.
    if (!*conf && named.size() < 2) return {};
    ScanSpec scan;
    scan.kind = ScanKind::Conf;
    scan.description = file;
    const auto views = formats::read_poses(**source);
    if (const auto kinds = formats::read_conf(**source); !*conf && !kinds.ok()) {
      scan.broken = kinds.error().text();
      claimed_.insert(named.begin(), named.end());
    } else if (!views.ok()) {
      scan.broken = views.error().text();
      claimed_.insert(named.begin(), named.end());
    } else if (views->front().name.empty()) {
      scan.broken = file + ": holds poses without names of files; name it in views as poses";
    } else {
      for (const formats::NamedPose& view : *views) {
        ViewSpec& spec = scan.views.emplace_back();
        spec.path = plain_path(folder_of(file) + view.name);
        spec.pose = view.pose;
        spec.pose_in_file_units = true;
      }
    }
    claimed_.insert(file);
    finish_described(std::move(scan));
    return {};
  }

  /// Only documents that name our key are parsed: archives hold JSON of all kinds and sizes.
  Result<void> look_at_document(const std::string& file) {
    const auto source = open(file);
    if (!source.ok()) return note_unreadable(source.error(), file);
    std::string start(std::min<std::uint64_t>((*source)->size(), kLook), '\0');
    const auto got = (*source)->read_at(0, std::span<char>(start.data(), start.size()));
    if (!got.ok()) return note_unreadable(got.error(), file);
    start.resize(*got);
    const bool lists_stations = begins_line(start, "stations") || start.find("\"stations\"") != std::string::npos;
    if ((start.find("scanmill_plan") == std::string::npos && !lists_stations) || (*source)->size() > kMaxPlan)
      return {};
    const auto text = read_all(**source, kMaxPlan);
    if (!text.ok()) return note_unreadable(text.error(), file);
    const auto tree = document::parse_yaml(*text, file);
    // A key misspelt or without its colon makes no scans of the stations: what lists stations whose files are here is
    // taken as a plan, and fails with what is wrong in it.
    const std::vector<std::string> named = files_named_in(*text, file);
    const bool is_plan = tree.ok() && tree->is_map() && tree->find("scanmill_plan") != nullptr;
    const bool claims = begins_line(start, "scanmill_plan") || formats::suffix_of(file) == "json";
    if (!is_plan && !(lists_stations && !named.empty()) && (tree.ok() || !claims)) return {};
    ScanSpec scan;
    scan.kind = ScanKind::Plan;
    scan.description = file;
    const Result<plan::ScanPlan> plan = tree.ok() ? plan::plan_from(*tree, file) : Result<plan::ScanPlan>(tree.error());
    if (plan.ok()) {
      views_of_plan(*plan, scan);
      judge_plan(*plan, scan);
    } else {
      scan.broken = plan.error().text();
      claimed_.insert(named.begin(), named.end());
      if (tree.ok()) claim_files_of_broken_plan(*tree, file);
    }
    claimed_.insert(file);
    finish_described(std::move(scan));
    return {};
  }

  /// Its views must not turn up as scans of their own because of a slip elsewhere in the plan.
  void claim_files_of_broken_plan(const document::Node& tree, const std::string& file) {
    const document::Node* stations = tree.is_map() ? tree.find("stations") : nullptr;
    if (stations == nullptr || !stations->is_sequence()) return;
    for (const document::Node& station : stations->items())
      if (const document::Node* data = station.find("data"); data != nullptr && data->is_string())
        claimed_.insert(plain_path(folder_of(file) + data->as_string()));
  }

  /// The same where the description cannot even be parsed: every file of points of the archive whose path, from the
  /// description's folder, stands in its text.
  std::vector<std::string> files_named_in(const std::string& text, const std::string& file) const {
    const std::string folder = folder_of(file);
    std::vector<std::string> named;
    for (const std::string& other : files_)
      if (other.starts_with(folder) && other != file && formats::is_point_suffix(formats::suffix_of(other)) &&
          names(text, other.substr(folder.size())))
        named.push_back(other);
    return named;
  }

  void finish_described(ScanSpec scan) {
    std::sort(scan.views.begin(), scan.views.end(),
              [](const ViewSpec& a, const ViewSpec& b) { return a.path < b.path; });
    std::size_t missing = 0;
    std::string absent;
    for (ViewSpec& view : scan.views) {
      claimed_.insert(view.path);
      view.missing = !present_.contains(view.path);
      missing += view.missing;
      if (!view.missing) continue;
      const std::string sentence = "the file " + view.path + " named in " + scan.description + " is not there";
      // A plan says what the scan is made of: without one of its views it is another scan.
      if (view.station.empty())
        scan.notes.push_back(sentence);
      else
        absent += (absent.empty() ? "" : "\n") + scan.description + ": station " + view.station + ": the file " +
                  view.path + " is not there; copy it, or take the station out of the plan";
    }
    if (scan.broken.empty() && missing < scan.views.size()) scan.broken = absent;
    if (scan.broken.empty() && missing == scan.views.size())
      scan.broken = scan.description + ": " +
                    (missing == 0 ? "names no file of points"
                                  : "none of the " + std::to_string(missing) +
                                        " files it names is there, the first is " + scan.views.front().path);
    found_.scans.push_back(std::move(scan));
  }

  bool takes_vertices(const std::string& file) const {
    if (!keys_.vertices_of) return keys_.mesh_vertices_as_scan;
    return keys_.vertices_of(file.substr(0, file.rfind('.')));
  }

  Result<void> look_for_points(const std::string& file) {
    const std::string suffix = formats::suffix_of(file);
    const bool is_mesh = suffix == "stl" || suffix == "obj" || suffix == "off";
    if (is_mesh && !takes_vertices(file))
      return note("with faces (set mesh_vertices_as_scan: true to take their vertices)", file), Result<void>{};
    if (is_mesh) {
      ScanSpec scan;
      scan.views.emplace_back().path = file;
      found_.scans.push_back(std::move(scan));
      return {};
    }
    if (formats::is_unsupported_suffix(suffix)) {
      // By name alone: opening thousands of files just to say no would not be cheap.
      note("of the suffix ." + suffix + " not read by this version", file);
      return {};
    }
    if (!formats::is_point_suffix(suffix)) return note_passed_over(file, suffix), Result<void>{};
    ScanSpec scan;
    ViewSpec& view = scan.views.emplace_back();
    view.path = file;
    const auto source = open(file);
    const auto probe = source.ok() ? formats::probe(**source) : Result<formats::Probe>(source.error());
    // A file that cannot be opened is a scan that fails when it is read; it must not vanish from the list.
    if (probe.ok() && keys_.format == formats::Format::Auto) {
      if (probe->kind == formats::FileKind::DepthMap) {
        found_.depth_maps.push_back(file);
        return note("of depth maps (name them in views, with intrinsics)", file), Result<void>{};
      }
      if (probe->kind == formats::FileKind::Unsupported)
        return note("of the format " + probe->format + " not read by this version", file), Result<void>{};
      if (probe->kind == formats::FileKind::Other)
        return note("holding no lines of three numbers", file), Result<void>{};
      if (probe->kind == formats::FileKind::PoseMatrices) return found_.pose_files.push_back(file), Result<void>{};
      if (probe->has_faces && !takes_vertices(file))
        return note("with faces (set mesh_vertices_as_scan: true to take their vertices)", file), Result<void>{};
    }
    found_.scans.push_back(std::move(scan));
    return {};
  }

  /// Files that are no scans by their names, but may be what somebody meant.
  void note_passed_over(const std::string& file, const std::string& suffix) {
    if (formats::is_packed_suffix(suffix)) return note("packed (." + suffix + ") and not looked into; unpack", file);
    if (suffix != "png" && !suffix.empty()) return;
    const auto source = open(file);
    if (!source.ok()) return;
    if (suffix == "png") {
      if (!formats::is_depth_map(**source)) return;
      found_.depth_maps.push_back(file);
      return note("of 16-bit grey PNG, perhaps depth maps (name them in views, with intrinsics and poses)", file);
    }
    const auto probe = formats::probe(**source);
    if (!probe.ok()) return;
    switch (probe->kind) {
      case formats::FileKind::Other:
      case formats::FileKind::PoseMatrices:
      case formats::FileKind::DepthMap:
        return;
      case formats::FileKind::Unsupported:
        return note("without a suffix, of the format " + probe->format + " not read by this version", file);
      default:
        return note("without a suffix holding points (rename to ." +
                        (probe->format == "text" ? std::string("xyz") : probe->format) + ", or name in views)",
                    file);
    }
  }

  Result<void> name_scans() {
    std::vector<std::string> paths;
    for (const ScanSpec& scan : found_.scans)
      paths.push_back(scan.description.empty() ? scan.views[0].path : scan.description);
    const std::vector<std::string> names = scan_names(paths), clashes = case_clashes(names, paths);
    for (std::size_t i = 0; i < names.size(); ++i) {
      found_.scans[i].name = names[i];
      if (!clashes[i].empty()) found_.scans[i].broken = clashes[i];
    }
    for (ScanSpec& scan : by_hand_) {
      for (const ScanSpec& other : found_.scans)
        if (lower(other.name) == lower(scan.name))
          return fail(Code::BadParameter, "views: found the name " + scan.name + ", which the scan " + other.name +
                                              " of the archive has already; choose another");
      found_.scans.push_back(std::move(scan));
    }
    std::sort(found_.scans.begin(), found_.scans.end(),
              [](const ScanSpec& a, const ScanSpec& b) { return a.name < b.name; });
    return {};
  }

  const std::string& archive_;
  const DiscoveryKeys& keys_;
  const std::vector<std::string>& files_;
  std::set<std::string> present_;
  std::set<std::string> claimed_;  // descriptions, and files that belong to them
  std::vector<ScanSpec> by_hand_;  // of `views`
  std::map<std::string, Group> groups_;
  Discovery found_;
};

/// Not a scan, but what a run wrote with the archive itself as its output folder.
bool is_result_in_root(const std::string& file, const std::set<std::string>& present) {
  return file.starts_with("logs/") || file.starts_with("journal/") ||
         (file.starts_with("scans/") && present.contains(folder_of(file) + "record.h5"));
}

/// Folders that a run wrote into the archive; their files leave the list, or each night would mesh the last one's
/// meshes.
std::vector<std::string> leave_out_own_output(std::vector<std::string>& files) {
  const std::set<std::string> present(files.begin(), files.end());
  std::vector<std::string> own;
  for (const std::string& file : files)
    if (const std::string folder = folder_of(file);
        file == folder + "run.json" && present.contains(folder + "journal/1.jsonl"))
      own.push_back(folder);
  std::erase_if(files, [&](const std::string& file) {
    return std::any_of(own.begin(), own.end(), [&](const std::string& folder) {
      return folder.empty() ? is_result_in_root(file, present) : file.starts_with(folder);
    });
  });
  return own;
}

}  // namespace

Result<Discovery> discover(const std::string& archive, const DiscoveryKeys& keys) {
  std::vector<std::string> links, others;
  TRY_ASSIGN(std::vector<std::string> files, store::list_files(archive, &links, &others));
  const std::vector<std::string> own = leave_out_own_output(files);
  TRY_ASSIGN(Discovery found, Finder(archive, keys, files).run());
  if (!own.empty())
    found.notes.push_back(counted(own.size(), "output folder") + " of scanmill " + (own.size() == 1 ? "is" : "are") +
                          " left out, the first is " + (own.front().empty() ? "the archive itself" : own.front()));
  if (!links.empty())
    found.notes.push_back(counted(links.size(), "link") + " out of the archive " + (links.size() == 1 ? "is" : "are") +
                          " not followed, the first is " + links.front() +
                          "; copy or mount what it leads to, or name that folder as archive");
  if (!others.empty())
    found.notes.push_back(grouped(others.size()) +
                          (others.size() == 1 ? " pipe, socket or device is" : " pipes, sockets or devices are") +
                          " left out, the first is " + others.front());
  return found;
}

}  // namespace scanmill::pipeline
