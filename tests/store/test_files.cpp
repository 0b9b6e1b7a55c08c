// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cerrno>

#include "store/files.hpp"
#include "store/reason.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::store {
namespace {

using support::TempFolder;

std::size_t entries_in(const std::string& folder) {
  std::size_t n = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++n;
  return n;
}

TEST(OpenFile, ReadsAnyPart) {
  const TempFolder folder;
  folder.write("a", "0123456789");
  const auto source = open_file(folder.file("a"), "shown");
  ASSERT_TRUE(source.ok());
  EXPECT_EQ((*source)->size(), 10u);
  EXPECT_EQ((*source)->name(), "shown");
  char buffer[8];
  EXPECT_EQ(*(*source)->read_at(7, buffer), 3u);
  EXPECT_EQ(std::string(buffer, 3), "789");
  EXPECT_EQ(*(*source)->read_at(10, buffer), 0u);
  EXPECT_EQ(*(*source)->read_at(~0ull, buffer), 0u);
}

TEST(OpenFile, SaysWhatItFoundInstead) {
  const TempFolder folder;
  const auto missing = open_file(folder.file("none"), "none");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, Code::BadInput);
  EXPECT_EQ(missing.error().text(), "none: there is no such file; check the path");
  const auto place = open_file(folder.path(), "place");
  ASSERT_FALSE(place.ok());
  EXPECT_EQ(place.error().text(), "place: this is a folder, wanted a file");
  ASSERT_EQ(::mkfifo(folder.file("pipe").c_str(), 0600), 0);
  const auto pipe = open_file(folder.file("pipe"), "pipe");
  ASSERT_FALSE(pipe.ok());
  EXPECT_EQ(pipe.error().code, Code::BadInput);
}

TEST(CreateFile, ShowsNothingBeforeCommit) {
  const TempFolder folder;
  folder.write("out", "old");
  {
    auto sink = create_file(folder.file("out"));
    ASSERT_TRUE(sink.ok());
    ASSERT_TRUE((*sink)->write(std::string_view("new")).ok());
    EXPECT_EQ(folder.read("out"), "old");
    EXPECT_EQ(entries_in(folder.path()), 2u);
    ASSERT_TRUE((*sink)->commit().ok());
  }
  EXPECT_EQ(folder.read("out"), "new");
  EXPECT_EQ(entries_in(folder.path()), 1u);
}

TEST(CreateFile, LeavesNoTraceWhenDropped) {
  const TempFolder folder;
  { ASSERT_TRUE((*create_file(folder.file("out")))->write(std::string_view("half")).ok()); }
  EXPECT_EQ(entries_in(folder.path()), 0u);
}

TEST(CreateFile, KeepsOrderOfSmallAndLargeWrites) {
  const TempFolder folder;
  auto sink = create_file(folder.file("out"));
  ASSERT_TRUE(sink.ok());
  std::string expected;
  for (const std::size_t size : {3u, 700000u, 700000u, 3000000u, 1u, 1048576u, 5u}) {
    const std::string part(size, static_cast<char>('a' + expected.size() % 23));
    ASSERT_TRUE((*sink)->write(std::string_view(part)).ok());
    expected += part;
  }
  ASSERT_TRUE((*sink)->commit().ok());
  EXPECT_EQ(folder.read("out"), expected);
}

TEST(CreateFile, NamesPathAndReason) {
  const auto sink = create_file("/nowhere/at/all/out");
  ASSERT_FALSE(sink.ok());
  EXPECT_EQ(sink.error().code, Code::IoFailed);
  EXPECT_EQ(sink.error().text(), "/nowhere/at/all/out: cannot create: No such file or directory");
  const TempFolder folder;
  EXPECT_FALSE(create_file(folder.path()).ok());
}

TEST(SystemFailure, TellsFullDiskFromOtherReasons) {
  EXPECT_EQ(system_failure(ENOSPC, "write", "f").code, Code::NoSpace);
  EXPECT_EQ(system_failure(EDQUOT, "write", "f").code, Code::NoSpace);
  EXPECT_EQ(system_failure(EIO, "write", "f").code, Code::IoFailed);
  EXPECT_NE(system_failure(ENOSPC, "write", "f").message.find("No space left"), std::string::npos);
}

TEST(StampOf, ChangesWithTheFile) {
  const TempFolder folder;
  folder.write("a", "1");
  const auto before = stamp_of(folder.file("a"));
  ASSERT_TRUE(before.ok());
  EXPECT_EQ(*before, *stamp_of(folder.file("a")));
  folder.write("a", "22");
  EXPECT_NE(*before, *stamp_of(folder.file("a")));
  EXPECT_FALSE(stamp_of(folder.file("none")).ok());
}

TEST(ListFiles, IsSortedAndLeavesHiddenAndBackupsOut) {
  const TempFolder folder;
  for (const char* name : {"b.ply", "a/z.ply", "a/.hidden", "a.ply", ".git/x", "c~", "d~/x", "A.ply"})
    folder.write(name, "");
  const auto files = list_files(folder.path() + "/");
  ASSERT_TRUE(files.ok());
  EXPECT_EQ(*files, (std::vector<std::string>{"A.ply", "a.ply", "a/z.ply", "b.ply"}));
  EXPECT_EQ(list_files(folder.file("none")).error().code, Code::BadInput);
  EXPECT_EQ(list_files(folder.file("a.ply")).error().code, Code::BadInput);
}

TEST(ListFiles, FollowsLinksInsideTheRootOnlyAndEnds) {
  const TempFolder outside, folder;
  outside.write("secret", "");
  folder.write("a/x", "");
  namespace fs = std::filesystem;
  fs::create_directory_symlink(outside.path(), folder.file("out"));
  fs::create_symlink(outside.file("secret"), folder.file("stolen"));
  fs::create_symlink(folder.file("a/x"), folder.file("link"));
  fs::create_directory_symlink(folder.path(), folder.file("a/up"));
  fs::create_directory_symlink(folder.file("a"), folder.file("b"));
  fs::create_symlink("nothing", folder.file("dangling"));
  const auto files = list_files(folder.path());
  ASSERT_TRUE(files.ok()) << files.error().text();
  EXPECT_EQ(*files, (std::vector<std::string>{"a/x", "b/x", "link"}));
}

TEST(ListFiles, TellsOfWhatIsNoFile) {
  const TempFolder folder;
  folder.write("a.ply", "");
  ASSERT_EQ(::mkfifo(folder.file("pipe.ply").c_str(), 0600), 0);
  std::vector<std::string> others;
  const auto files = list_files(folder.path(), nullptr, &others);
  ASSERT_TRUE(files.ok()) << files.error().text();
  EXPECT_EQ(*files, std::vector<std::string>{"a.ply"});
  EXPECT_EQ(others, std::vector<std::string>{"pipe.ply"});
}

TEST(ReplaceFolder, PutsTheNewOneInPlaceAndRemovesTheOld) {
  const TempFolder folder;
  folder.write("new/mesh", "2");
  folder.write("new/deep/record", "2");
  folder.write("old/mesh", "1");
  folder.write("old/gone", "1");
  ASSERT_TRUE(replace_folder(folder.file("new"), folder.file("old")).ok());
  EXPECT_EQ(folder.read("old/mesh"), "2");
  EXPECT_EQ(folder.read("old/deep/record"), "2");
  EXPECT_FALSE(exists(folder.file("old/gone")));
  EXPECT_FALSE(exists(folder.file("new")));
  folder.write("new/mesh", "3");
  ASSERT_TRUE(replace_folder(folder.file("new"), folder.file("fresh")).ok());
  EXPECT_EQ(folder.read("fresh/mesh"), "3");
  EXPECT_FALSE(replace_folder(folder.file("new"), folder.file("fresh")).ok());
}

TEST(Folders, AreMadeAndRemovedWithoutComplaint) {
  const TempFolder folder;
  EXPECT_TRUE(make_folders(folder.file("a/b/c")).ok());
  EXPECT_TRUE(make_folders(folder.file("a/b/c")).ok());
  EXPECT_TRUE(is_folder(folder.file("a/b/c")));
  folder.write("file", "");
  EXPECT_FALSE(make_folders(folder.file("file")).ok());
  EXPECT_TRUE(remove_tree(folder.file("a")).ok());
  EXPECT_TRUE(remove_tree(folder.file("a")).ok());
}

}  // namespace
}  // namespace scanmill::store
