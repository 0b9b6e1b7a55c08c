// SPDX-License-Identifier: Apache-2.0
// Folders: listing an archive, and the one switch that puts a finished folder in place.
#include <fcntl.h>
#include <stdio.h>  // renameat2
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "store/files.hpp"
#include "store/reason.hpp"

namespace scanmill::store {
namespace {

namespace fs = std::filesystem;

/// "lost+found" belongs to the file system and is closed to all but root.
bool is_left_out(const std::string& name) {
  return name.empty() || name.front() == '.' || name.back() == '~' || name == "lost+found";
}

std::string resolved(const std::string& path) {
  std::error_code error;
  const fs::path real = fs::canonical(path, error);
  return error ? std::string() : real.string();
}

bool lies_in(const std::string& path, const std::string& root) {
  if (path.empty()) return false;
  if (root == "/" || path == root) return true;
  return path.size() > root.size() && path.compare(0, root.size(), root) == 0 && path[root.size()] == '/';
}

/// Depth first over one tree. A link is followed when its target stays in the tree; a folder link only when it is no
/// folder we are inside of and not met below another folder link (n folders that all link to each other would give n!
/// paths).
class Lister {
 public:
  Lister(std::string root, std::vector<std::string>* links_left, std::vector<std::string>* others_left)
      : root_(std::move(root)), real_root_(resolved(root_)), links_left_(links_left), others_left_(others_left) {}

  Result<void> walk(const std::string& relative, std::vector<std::string>& files) {
    const std::string folder = relative.empty() ? root_ : root_ + "/" + relative;
    inside_.push_back(resolved(folder));
    std::error_code error;
    fs::directory_iterator entries(folder, error);
    if (error) return system_failure(error.value(), "list", folder);
    for (const fs::directory_iterator end; entries != end;) {
      const std::string name = entries->path().filename().string();
      if (!is_left_out(name)) TRY(visit(relative.empty() ? name : relative + "/" + name, *entries, files));
      entries.increment(error);
      if (error) return system_failure(error.value(), "list", folder);
    }
    inside_.pop_back();
    return {};
  }

 private:
  Result<void> visit(const std::string& relative, const fs::directory_entry& entry, std::vector<std::string>& files) {
    std::error_code error;
    const bool link = entry.is_symlink(error);
    const std::string real = link ? resolved(entry.path().string()) : std::string();
    if (link && !lies_in(real, real_root_)) {
      if (links_left_ != nullptr) links_left_->push_back(relative);
      return {};
    }
    if (entry.is_regular_file(error)) {
      files.push_back(relative);
    } else if (entry.is_directory(error)) {
      if (!link) return walk(relative, files);
      if (below_link_ || std::find(inside_.begin(), inside_.end(), real) != inside_.end()) return {};
      below_link_ = true;
      TRY(walk(relative, files));
      below_link_ = false;
    } else if (others_left_ != nullptr && entry.exists(error)) {
      others_left_->push_back(relative);
    }
    return {};
  }

  std::string root_, real_root_;
  std::vector<std::string>*links_left_, *others_left_;
  std::vector<std::string> inside_;
  bool below_link_ = false;
};

std::string parent_of(const std::string& path) {
  const fs::path parent = fs::path(path).parent_path();
  return parent.empty() ? "." : parent.string();
}

std::string without_last_slash(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

/// Files first, then the folder that names them.
Result<void> sync_tree(const std::string& path) {
  std::error_code error;
  fs::directory_iterator entries(path, error);
  if (error) return system_failure(error.value(), "list", path);
  for (const fs::directory_iterator end; entries != end;) {
    const std::string child = entries->path().string();
    if (!entries->is_symlink(error)) TRY(entries->is_directory(error) ? sync_tree(child) : sync_file(child));
    entries.increment(error);
    if (error) return system_failure(error.value(), "list", path);
  }
  return sync_folder(path);
}

/// For file systems that know no exchange: for a moment nothing is under the final name, never something half-done.
Result<void> swap_by_two_renames(const std::string& from, const std::string& to) {
  const std::string aside = to + ".old-" + std::to_string(::getpid());
  if (::rename(to.c_str(), aside.c_str()) != 0) return system_failure(errno, "move aside", to);
  if (::rename(from.c_str(), to.c_str()) != 0) {
    const int reason = errno;
    ::rename(aside.c_str(), to.c_str());
    return system_failure(reason, "move into place", to);
  }
  if (::rename(aside.c_str(), from.c_str()) != 0) return system_failure(errno, "move the old folder away", to);
  return {};
}

}  // namespace

Result<std::vector<std::string>> list_files(const std::string& root, std::vector<std::string>* links_left,
                                            std::vector<std::string>* others_left) {
  std::error_code error;
  const fs::file_status status = fs::status(root, error);
  if (!fs::exists(status)) return fail(Code::BadInput, "there is no such folder; check the path", root);
  if (!fs::is_directory(status)) return fail(Code::BadInput, "this is a file, wanted a folder", root);
  std::vector<std::string> files;
  TRY(Lister(without_last_slash(root), links_left, others_left).walk("", files));
  std::sort(files.begin(), files.end());
  for (std::vector<std::string>* left : {links_left, others_left})
    if (left != nullptr) std::sort(left->begin(), left->end());
  return files;
}

Result<void> make_folders(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) return system_failure(error.value(), "make the folder", path);
  if (!is_folder(path)) return fail(Code::IoFailed, "a file stands where a folder is wanted; move it away", path);
  return {};
}

Result<void> remove_tree(const std::string& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (error) return system_failure(error.value(), "remove", path);
  return {};
}

bool is_folder(const std::string& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

bool exists(const std::string& path) {
  std::error_code error;
  return fs::exists(path, error);
}

namespace {

/// True when there was a folder before, which stands at `from` now. Others may put theirs there, or take it away, at
/// the same time: each of them ends with its own in place for a moment.
Result<bool> put_in_place(const std::string& from, const std::string& to) {
  constexpr int kTries = 16;
  for (int tries = 1;; ++tries) {
    if (exists(to)) {
      if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_EXCHANGE) == 0) return true;
      if (errno == EINVAL || errno == ENOSYS) {
        TRY(swap_by_two_renames(from, to));
        return true;
      }
      if (errno != ENOENT || tries == kTries) break;  // else: gone in between
    } else {
      if (::rename(from.c_str(), to.c_str()) == 0) return false;
      if ((errno != EEXIST && errno != ENOTEMPTY) || tries == kTries) break;  // else: come in between
    }
  }
  return system_failure(errno, "put the finished folder in place", to);
}

}  // namespace

Result<void> replace_folder(const std::string& from_path, const std::string& to_path) {
  const std::string from = without_last_slash(from_path), to = without_last_slash(to_path);
  if (!is_folder(from)) return fail(Code::IoFailed, "this folder should hold finished files but is not there", from);
  TRY(sync_tree(from));
  TRY_ASSIGN(const bool swapped, put_in_place(from, to));
  TRY(sync_folder(parent_of(to)));
  if (parent_of(from) != parent_of(to)) TRY(sync_folder(parent_of(from)));
  if (swapped) TRY(remove_tree(from));
  return {};
}

}  // namespace scanmill::store
