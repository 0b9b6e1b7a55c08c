// SPDX-License-Identifier: Apache-2.0
// One file in, one file out. A file under its final name is complete and synced; anything else has a temporary name.
#include "store/files.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>

#include "store/reason.hpp"

namespace scanmill::store {
namespace {

constexpr std::size_t kWriteBuffer = 1 << 20;

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() { close(); }
  int number() const { return number_; }
  /// The result of close(2); network file systems report late write errors here.
  int close() {
    const int number = number_;
    number_ = -1;
    return number >= 0 ? ::close(number) : 0;
  }

 private:
  int number_;
};

class PreadSource final : public ByteSource {
 public:
  PreadSource(int descriptor, std::string name, std::uint64_t size)
      : file_(descriptor), name_(std::move(name)), size_(size) {}
  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return size_; }

  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> out) const override {
    if (offset >= size_) return std::size_t{0};
    const std::size_t wanted = std::min<std::uint64_t>(out.size(), size_ - offset);
    std::size_t got = 0;
    while (got < wanted) {
      const ssize_t n = ::pread(file_.number(), out.data() + got, wanted - got, static_cast<off_t>(offset + got));
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return system_failure(errno, "read", name_);
      if (n == 0) break;
      got += static_cast<std::size_t>(n);
    }
    return got;
  }

 private:
  Descriptor file_;
  std::string name_;
  std::uint64_t size_;
};

/// A new name beside the target at each call, so two writers of one process never meet.
std::string temporary_name(const std::string& path) {
  static std::atomic<unsigned> counter{0};
  return path + ".tmp-" + std::to_string(::getpid()) + "-" + std::to_string(counter++);
}

std::string folder_of(const std::string& path) {
  const auto slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

class AtomicSink final : public ByteSink {
 public:
  AtomicSink(int descriptor, std::string path, std::string temporary)
      : file_(descriptor), path_(std::move(path)), temporary_(std::move(temporary)) {
    buffer_.reserve(kWriteBuffer);
  }
  ~AtomicSink() override {
    if (!committed_) ::unlink(temporary_.c_str());
  }
  const std::string& name() const override { return path_; }

  Result<void> write(std::span<const char> bytes) override {
    if (buffer_.size() + bytes.size() > kWriteBuffer) TRY(flush());
    if (bytes.size() >= kWriteBuffer) return write_through(bytes);
    buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
    return {};
  }

  Result<void> commit() override {
    if (committed_) return {};
    TRY(flush());
    if (::fsync(file_.number()) != 0) return system_failure(errno, "sync", path_);
    TRY(put_in_place());
    return sync_folder(folder_of(path_));
  }

  /// As commit(), without a sync.
  Result<void> commit_scratch() {
    TRY(flush());
    return put_in_place();
  }

 private:
  Result<void> put_in_place() {
    if (file_.close() != 0) return system_failure(errno, "close", path_);
    if (::rename(temporary_.c_str(), path_.c_str()) != 0) return system_failure(errno, "rename into place", path_);
    committed_ = true;
    return {};
  }
  Result<void> flush() {
    TRY(write_through(buffer_));
    buffer_.clear();
    return {};
  }
  Result<void> write_through(std::span<const char> bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::write(file_.number(), bytes.data(), bytes.size());
      if (n < 0 && errno == EINTR) continue;
      if (n < 0) return system_failure(errno, "write", path_);
      bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return {};
  }

  Descriptor file_;
  std::string path_, temporary_;
  std::vector<char> buffer_;
  bool committed_ = false;
};

FileStamp stamp_from(const struct stat& status) {
  // Times are what their owner set them to: nanoseconds fit 64 bits from 1690 to 2250, anything else counts as the end.
  constexpr std::int64_t kLastSecond = 280LL * 365 * 86400;
  const std::int64_t second = std::clamp<std::int64_t>(status.st_mtim.tv_sec, -kLastSecond, kLastSecond);
  return {static_cast<std::uint64_t>(status.st_size), second * 1000000000 + status.st_mtim.tv_nsec,
          static_cast<std::uint64_t>(status.st_ino)};
}

}  // namespace

Result<std::shared_ptr<const ByteSource>> open_file(const std::string& path, const std::string& shown) {
  // O_NONBLOCK: a pipe without a writer would hang here for ever; it changes nothing for files.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0 && (errno == ENOENT || errno == ENOTDIR))
    return fail(Code::BadInput, "there is no such file; check the path", shown);
  if (descriptor < 0) return system_failure(errno, "open for reading", shown);
  struct stat status {};
  const int failed = ::fstat(descriptor, &status) != 0 ? errno : 0;
  if (failed != 0 || !S_ISREG(status.st_mode)) {
    ::close(descriptor);
    if (failed != 0) return system_failure(failed, "look at", shown);
    if (S_ISDIR(status.st_mode)) return fail(Code::BadInput, "this is a folder, wanted a file", shown);
    return fail(Code::BadInput, "this is a pipe, socket or device, wanted a file", shown);
  }
  return std::shared_ptr<const ByteSource>(
      std::make_shared<PreadSource>(descriptor, shown, static_cast<std::uint64_t>(status.st_size)));
}

namespace {

Result<std::unique_ptr<AtomicSink>> begin_file(const std::string& path) {
  if (path.empty()) return fail(Code::IoFailed, "an output file needs a name");
  if (is_folder(path)) return fail(Code::IoFailed, "this is a folder; an output file cannot take its place", path);
  const std::string temporary = temporary_name(path);
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) return system_failure(errno, "create", path);
  return std::make_unique<AtomicSink>(descriptor, path, temporary);
}

}  // namespace

Result<std::unique_ptr<ByteSink>> create_file(const std::string& path) {
  TRY_ASSIGN(auto sink, begin_file(path));
  return std::unique_ptr<ByteSink>(std::move(sink));
}

Result<void> write_text(const std::string& path, std::string_view text) {
  TRY_ASSIGN(const auto sink, create_file(path));
  TRY(sink->write(text));
  return sink->commit();
}

Result<void> write_scratch(const std::string& path, std::string_view text) {
  TRY_ASSIGN(const auto sink, begin_file(path));
  TRY(sink->write(text));
  return sink->commit_scratch();
}

std::optional<std::uint64_t> free_space(const std::string& folder) {
  struct statvfs status {};
  if (::statvfs(folder.c_str(), &status) != 0) return std::nullopt;
  return static_cast<std::uint64_t>(status.f_bavail) * static_cast<std::uint64_t>(status.f_frsize);
}

Result<FileStamp> stamp_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return system_failure(errno, "look at", path);
  return stamp_from(status);
}

Result<void> sync_folder(const std::string& path) {
  const Descriptor folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.number() < 0) return system_failure(errno, "open for syncing", path);
  // Some network file systems cannot sync a folder and say so with EINVAL; there the rename itself is durable.
  if (::fsync(folder.number()) != 0 && errno != EINVAL && errno != EROFS) return system_failure(errno, "sync", path);
  return {};
}

Result<void> sync_file(const std::string& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.number() < 0) return system_failure(errno, "open for syncing", path);
  if (::fsync(file.number()) != 0) return system_failure(errno, "sync", path);
  return {};
}

}  // namespace scanmill::store
