// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>

#include "base/bytes.hpp"
#include "base/digest.hpp"

namespace scanmill {
namespace {

/// Claims more bytes than it gives: a file that was cut after it was opened.
class Shrunk final : public ByteSource {
 public:
  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return 100; }
  Result<std::size_t> read_at(std::uint64_t offset, std::span<char> out) const override {
    const std::size_t n = offset < 40 ? std::min<std::size_t>(out.size(), 40 - offset) : 0;
    std::fill_n(out.begin(), n, 'x');
    return n;
  }

 private:
  std::string name_ = "shrunk";
};

TEST(Sha256, EqualsThePublishedExamples) {  // FIPS 180-2, appendix B
  EXPECT_EQ(sha256_hex(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_hex(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(Sha256, DoesNotSeeHowBytesAreSplit) {
  Sha256 hash;
  for (const char* part : {"a", "", "bc"}) hash.add(part);
  EXPECT_EQ(hash.hex(), sha256_hex("abc"));
  std::string large(3 << 20, '\0');
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(mix64(i));
  const auto of_source = sha256_of(*memory_source("large", large));
  ASSERT_TRUE(of_source.ok());
  EXPECT_EQ(*of_source, sha256_hex(large));
}

TEST(Sha256, FailsOnASourceThatBecameShorter) {
  const auto hash = sha256_of(Shrunk());
  ASSERT_FALSE(hash.ok());
  EXPECT_EQ(hash.error().code, Code::IoFailed);
  EXPECT_EQ(hash.error().where, "shrunk");
}

TEST(MemorySource, GivesFewerBytesOnlyAtItsEnd) {
  const auto source = memory_source("name", "0123456789");
  char buffer[4];
  EXPECT_EQ(*source->read_at(0, buffer), 4u);
  EXPECT_EQ(*source->read_at(8, buffer), 2u);
  EXPECT_EQ(buffer[1], '9');
  EXPECT_EQ(*source->read_at(10, buffer), 0u);
  EXPECT_EQ(*source->read_at(~std::uint64_t{0}, buffer), 0u);
}

TEST(MemorySink, LeavesNoTraceWithoutCommit) {
  std::string bytes = "before";
  {
    const auto sink = memory_sink("name", bytes);
    ASSERT_TRUE(sink->write(std::string_view("lost")).ok());
  }
  EXPECT_EQ(bytes, "before");
  const auto sink = memory_sink("name", bytes);
  ASSERT_TRUE(sink->write(std::string_view("a")).ok());
  ASSERT_TRUE(sink->write(std::string_view("bc")).ok());
  EXPECT_EQ(bytes, "before");
  ASSERT_TRUE(sink->commit().ok());
  EXPECT_EQ(bytes, "abc");
}

TEST(ReadAll, RefusesMoreThanItsLimit) {
  const auto source = memory_source("job.yaml", "0123456789");
  EXPECT_EQ(*read_all(*source, 10), "0123456789");
  const auto refused = read_all(*source, 9);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().text(), "job.yaml: the file has 10 bytes, more than the 9 a file of this kind may have");
}

TEST(ReadAll, FailsOnASourceThatBecameShorter) {
  const auto bytes = read_all(Shrunk(), 1000);
  ASSERT_FALSE(bytes.ok()) << bytes.value().size() << " bytes of 100 were taken for the whole";
  EXPECT_EQ(bytes.error().code, Code::IoFailed);
}

}  // namespace
}  // namespace scanmill
