// SPDX-License-Identifier: Apache-2.0
#include "runner/output_tree.hpp"

#include <algorithm>
#include <filesystem>

#include "runner/scan_state.hpp"
#include "store/files.hpp"

namespace scanmill::runner {

namespace fs = std::filesystem;

Result<void> OutputTree::prepare() const {
  for (const char* part : {"/scans", "/logs", "/journal"}) TRY(store::make_folders(root_ + part));
  return {};
}

std::vector<std::string> OutputTree::leftovers() const {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::recursive_directory_iterator it(root_ + "/scans", error), end; !error && it != end; it.increment(error)) {
    // Scan names never begin with a dot, so every hidden folder is an attempt (or what an attempt replaced).
    if (!it->is_directory(error) || it->path().filename().string().front() != '.') continue;
    found.push_back(it->path().string());
    it.disable_recursion_pending();
  }
  for (const char* part : {"", "/journal", "/logs"})
    for (fs::directory_iterator it(root_ + part, error), end; !error && it != end; it.increment(error))
      if (it->path().filename().string().find(".tmp-") != std::string::npos) found.push_back(it->path().string());
  return found;
}

Result<void> OutputTree::remove_leftovers() const {
  for (const std::string& path : leftovers()) TRY(store::remove_tree(path));
  return {};
}

Result<std::string> OutputTree::begin_attempt(const std::string& name) const {
  const fs::path final = scan(name);
  TRY(store::make_folders(final.parent_path().string()));
  for (int attempt = 1;; ++attempt) {
    const std::string path =
        (final.parent_path() / ("." + final.filename().string() + "." + std::to_string(attempt))).string();
    std::error_code error;
    if (fs::create_directory(path, error)) return path;  // false when it is there: another task may have made it
    if (error && !store::exists(path)) TRY(store::make_folders(path));
    if (error && store::is_folder(path)) return path;
  }
}

Result<void> OutputTree::commit(const std::string& attempt, const std::string& name) const {
  return store::replace_folder(attempt, scan(name));
}

void OutputTree::remove_attempts(const std::string& name) const {
  const fs::path final = scan(name);
  const std::string begin = "." + final.filename().string() + ".";
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator it(final.parent_path(), error), end; !error && it != end; it.increment(error))
    if (const std::string part = it->path().filename().string();
        part.starts_with(begin) && part.find_first_not_of("0123456789", begin.size()) == std::string::npos)
      found.push_back(it->path().string());
  for (const std::string& path : found) (void)store::remove_tree(path);  // what stays goes with the next run
}

void OutputTree::remove_parts(const std::string& name) const {
  if (!store::exists(parts(name))) return;
  (void)store::remove_tree(parts(name));
  std::error_code error;
  for (fs::path folder = fs::path(parts(name)).parent_path(); folder != fs::path(root_) && fs::remove(folder, error);)
    folder = folder.parent_path();
}

std::uint64_t OutputTree::bytes_of_parts(const std::string& name) const {
  std::uint64_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator it(parts(name), error), end; !error && it != end; it.increment(error)) {
    std::error_code unknown;
    const std::uintmax_t bytes = it->is_regular_file(unknown) ? it->file_size(unknown) : 0;
    sum += unknown ? 0 : bytes;
  }
  return sum;
}

std::vector<std::string> OutputTree::finished() const {
  std::vector<std::string> names;
  std::error_code error;
  const fs::path top = root_ + "/scans";
  for (fs::recursive_directory_iterator it(top, error), end; !error && it != end; it.increment(error)) {
    if (!it->is_directory(error)) continue;
    if (it->path().filename().string().front() == '.')
      it.disable_recursion_pending();
    else if (store::exists(it->path().string() + "/" + kStateFile))
      names.push_back(it->path().lexically_relative(top).generic_string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

bool OutputTree::is_unwritable() const {
  const std::string path = root_ + "/journal/probe";
  const bool fine = store::write_text(path, std::string(65536, ' ')).ok();
  (void)store::remove_tree(path);
  return !fine;
}

Result<void> check_out_of_archive(const OutputTree& tree, const std::string& archive) {
  std::error_code error;
  const fs::path held = fs::weakly_canonical(fs::absolute(archive), error);
  if (error) return {};
  for (const char* part : {"", "/scans", "/logs", "/journal"}) {
    fs::path folder = fs::weakly_canonical(fs::absolute(tree.root() + part), error);
    if (error) continue;
    if (!folder.has_filename()) folder = folder.parent_path();
    const auto [end, unused] = std::mismatch(folder.begin(), folder.end(), held.begin(), held.end());
    const bool inside = end == folder.end();
    if (*part ? inside : folder == held)
      return fail(Code::BadUsage,
                  "the archive " + archive +
                      (*part ? " lies in " + tree.root() + part + ", which a run writes to" : "") +
                      (*part ? "" : " is the output folder itself") +
                      "; results among the scans would be taken for scans: choose another --out",
                  tree.root());
  }
  return {};
}

}  // namespace scanmill::runner
