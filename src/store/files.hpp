// SPDX-License-Identifier: Apache-2.0
// Files and folders: the only module (with libraries that insist, HDF5) that sees paths.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/bytes.hpp"

namespace scanmill::store {

/// A file by pread; `shown` is the name for messages.
/// errors  BadInput when it does not exist or is a folder (what was found), IoFailed with the system's reason otherwise
Result<std::shared_ptr<const ByteSource>> open_file(const std::string& path, const std::string& shown);

/// Writes "<path>.tmp-<pid>-<n>" beside the target; commit = flush, fsync, rename over the target, fsync of the folder.
/// Dropped without commit: the temporary file is removed.
/// errors  NoSpace (ENOSPC, EDQUOT) or IoFailed with path and system reason
Result<std::unique_ptr<ByteSink>> create_file(const std::string& path);

/// What a file is now, for "did it change": size, mtime in ns, inode.
struct FileStamp {
  std::uint64_t size = 0;
  std::int64_t mtime_ns = 0;
  std::uint64_t inode = 0;
  friend bool operator==(const FileStamp&, const FileStamp&) = default;
};
Result<FileStamp> stamp_of(const std::string& path);

/// Writes a small file in one step.
/// errors  NoSpace, IoFailed naming it
Result<void> write_text(const std::string& path, std::string_view text);

/// The same for what nobody misses after a crash: readers see the old text or the new, but nothing is synced.
Result<void> write_scratch(const std::string& path, std::string_view text);
/// Bytes that can still be written below a folder; nothing when the system does not tell.
std::optional<std::uint64_t> free_space(const std::string& folder);

/// All regular files below `root` (links followed, never out of `root`), relative paths with '/', in byte order; hidden
/// ("." first) and "~" (last) files and folders are left out. `links_left` gets the links that lead out of the root,
/// `others_left` what is no file: pipes, sockets, devices.
Result<std::vector<std::string>> list_files(const std::string& root, std::vector<std::string>* links_left = nullptr,
                                            std::vector<std::string>* others_left = nullptr);

Result<void> make_folders(const std::string& path);
/// Removes a folder and everything below it; no error when it is not there.
Result<void> remove_tree(const std::string& path);
/// True for an existing folder.
bool is_folder(const std::string& path);
bool exists(const std::string& path);
/// Atomically puts the complete folder `from` in the place of `to`: renameat2(RENAME_EXCHANGE) and removal of the old
/// one, a plain rename when `to` is not there. Everything below `from` is synced first.
Result<void> replace_folder(const std::string& from, const std::string& to);
/// Makes what was written or renamed below a name durable (fsync).
Result<void> sync_file(const std::string& path);
Result<void> sync_folder(const std::string& path);

}  // namespace scanmill::store
