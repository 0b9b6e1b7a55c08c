// SPDX-License-Identifier: Apache-2.0
#include "base/bytes.hpp"

#include <algorithm>

namespace scanmill {
namespace {

class MemorySource final : public ByteSource {
 public:
  MemorySource(std::string name, std::string bytes) : name_(std::move(name)), bytes_(std::move(bytes)) {}
  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return bytes_.size(); }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> out) const override {
    if (offset >= bytes_.size()) return std::size_t{0};
    const std::size_t n = std::min<std::uint64_t>(out.size(), bytes_.size() - offset);
    std::copy_n(bytes_.data() + offset, n, out.data());
    return n;
  }

 private:
  std::string name_, bytes_;
};

class MemorySink final : public ByteSink {
 public:
  MemorySink(std::string name, std::string& target) : name_(std::move(name)), target_(target) {}
  const std::string& name() const override { return name_; }
  Result<void> write(std::span<const char> bytes) override {
    pending_.append(bytes.data(), bytes.size());
    return {};
  }
  Result<void> commit() override {
    target_ = std::move(pending_);
    return {};
  }

 private:
  std::string name_, pending_;
  std::string& target_;
};

}  // namespace

std::unique_ptr<ByteSource> memory_source(std::string name, std::string bytes) {
  return std::make_unique<MemorySource>(std::move(name), std::move(bytes));
}
std::unique_ptr<ByteSink> memory_sink(std::string name, std::string& bytes) {
  return std::make_unique<MemorySink>(std::move(name), bytes);
}

Result<std::string> read_all(const ByteSource& source, std::uint64_t limit) {
  if (source.size() > limit)
    return fail(Code::BadInput,
                "the file has " + std::to_string(source.size()) + " bytes, more than the " + std::to_string(limit) +
                    " a file of this kind may have",
                source.name());
  std::string bytes(source.size(), '\0');
  TRY_ASSIGN(const std::size_t got, source.read_at(0, std::span<char>(bytes.data(), bytes.size())));
  if (got != bytes.size()) return fail(Code::IoFailed, "the file became shorter while it was read", source.name());
  return bytes;
}

}  // namespace scanmill
