// SPDX-License-Identifier: Apache-2.0
#include "runner/slurm_waves.hpp"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>

#include "base/text.hpp"
#include "runner/slurm_client.hpp"
#include "runner/task.hpp"
#include "runner/task_result.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

namespace fs = std::filesystem;

namespace {

constexpr const char* kNameFile = "/name";
constexpr const char* kScriptFile = "/script.sh";
constexpr const char* kClockFile = "/clock";
constexpr const char* kBegan = ".began";
constexpr std::size_t kLongestStem = 24;

std::string work_folder(const OutputTree& tree) { return tree.root() + "/work"; }

}  // namespace

std::string wave_job_name(const std::string& job_path, const std::string& token) {
  std::string stem;
  for (const char c : fs::path(job_path).stem().string().substr(0, kLongestStem))
    stem += std::isalnum(static_cast<unsigned char>(c)) ? c : '-';
  return "scanmill-" + stem + "-" + token;
}

std::string began_name(const std::string& index, const std::string& number) { return index + "." + number + kBegan; }

std::optional<std::pair<std::size_t, std::uint64_t>> began_numbers(const std::string& name) {
  if (!name.ends_with(kBegan)) return std::nullopt;
  std::pair<std::size_t, std::uint64_t> numbers;
  const char *at = name.data(), *end = at + name.size() - std::string_view(kBegan).size();
  const auto [dot, bad_index] = std::from_chars(at, end, numbers.first);
  if (bad_index != std::errc() || dot == end || *dot != '.') return std::nullopt;
  const auto [rest, bad_number] = std::from_chars(dot + 1, end, numbers.second);
  if (bad_number != std::errc() || rest != end) return std::nullopt;
  return numbers;
}

Result<WaveFolder> make_wave(const OutputTree& tree, const TaskFile& file, const std::string& name,
                             const std::string& script) {
  WaveFolder wave{work_folder(tree) + "/" + file.token, name};
  TRY(store::make_folders(wave.folder));
  TRY(store::write_text(wave.folder + kNameFile, name + "\n"));
  TRY(store::write_text(wave.folder + kScriptFile, script));
  TRY(store::write_text(wave.worklist(), document::to_json(to_document(file)) + "\n"));
  TRY(store::sync_folder(work_folder(tree)));
  return wave;
}

std::vector<WaveFolder> open_waves(const OutputTree& tree) {
  std::vector<WaveFolder> waves;
  std::error_code error;
  for (fs::directory_iterator it(work_folder(tree), error), end; !error && it != end; it.increment(error)) {
    WaveFolder wave{it->path().string(), {}};
    if (!store::exists(wave.worklist()) || store::exists(wave.folder + "/" + kRevokedFile)) continue;
    if (const auto source = store::open_file(wave.folder + kNameFile, kNameFile))
      if (const auto text = read_all(**source, 4096)) wave.name = lines_of(*text).front();
    waves.push_back(std::move(wave));
  }
  std::sort(waves.begin(), waves.end(), [](const WaveFolder& a, const WaveFolder& b) { return a.folder < b.folder; });
  return waves;
}

bool has_open_waves(const OutputTree& tree) { return !open_waves(tree).empty(); }

void close_wave(const WaveFolder& wave) {
  // The mark comes first: a task that is between two looks at it must find one of the two.
  (void)store::write_scratch(wave.folder + "/" + kRevokedFile, "\n");
  (void)unlink(wave.worklist().c_str());
  (void)store::remove_tree(wave.folder);  // a file that a node holds open on NFS stays until a later run
}

std::vector<SignOfLife> signs_of(const WaveFolder& wave) {
  std::vector<SignOfLife> signs;
  std::error_code error;
  for (fs::directory_iterator it(wave.folder, error), end; !error && it != end; it.increment(error))
    if (const auto index = heartbeat_index(it->path().filename().string()))
      if (const auto stamp = store::stamp_of(it->path().string()))
        signs.push_back({it->path().string(), *index, stamp->mtime_ns});
  return signs;
}

double age_by_folder(const WaveFolder& wave, std::int64_t time_ns) {
  (void)store::write_scratch(wave.folder + kClockFile, "\n");
  const auto now = store::stamp_of(wave.folder + kClockFile);
  return now ? std::max(0.0, 1e-9 * static_cast<double>(now->mtime_ns - time_ns)) : 0;
}

std::size_t abandon_waves(const OutputTree& tree, bool keep_slurm) {
  const auto waves = open_waves(tree);
  const SlurmClient slurm;
  std::size_t closed = 0;
  for (const WaveFolder& wave : waves) {
    if (keep_slurm && !wave.name.empty()) continue;
    ++closed;
    if (!wave.name.empty()) (void)slurm.cancel(wave.name, "", "");  // without it they put nothing in place either
    close_wave(wave);
  }
  // Folders of closed waves whose files were held open then.
  std::error_code error;
  std::vector<std::string> remains;
  for (fs::directory_iterator it(work_folder(tree), error), end; !error && it != end; it.increment(error))
    if (it->path().filename() != kPartsFolder && !store::exists(it->path().string() + "/" + kTaskFileName))
      remains.push_back(it->path().string());
  for (const std::string& folder : remains) (void)store::remove_tree(folder);
  (void)rmdir(work_folder(tree).c_str());
  return closed;
}

}  // namespace scanmill::runner
