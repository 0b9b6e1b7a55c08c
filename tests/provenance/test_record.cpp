// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "provenance/record.hpp"
#include "provenance/sample/sample_record.hpp"
#include "provenance/stored_record.hpp"

namespace scanmill::provenance {
namespace {

namespace fs = std::filesystem;

/// A folder of this test alone, gone afterwards.
class RecordFile : public testing::Test {
 protected:
  RecordFile()
      : folder_(testing::TempDir() + "scanmill-record-" +
                testing::UnitTest::GetInstance()->current_test_info()->name() + "-" + std::to_string(::getpid())) {
    fs::create_directories(folder_);
    scan_ = sample::make_scan("");
    scan_.record.mesh = &scan_.mesh;
  }
  ~RecordFile() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  std::string write(const std::string& name) const {
    const auto identity = write_record(scan_.record, path(name));
    EXPECT_TRUE(identity.ok()) << identity.error().text();
    return identity.ok() ? *identity : "";
  }
  static std::string bytes_of(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

  std::string folder_;
  sample::SampleScan scan_;
};

TEST_F(RecordFile, HasTheSameBytesWhenWrittenTwice) {
  write("a.h5");
  write("b.h5");
  const std::string a = bytes_of(path("a.h5"));
  ASSERT_GT(a.size(), 1000u);
  EXPECT_TRUE(a == bytes_of(path("b.h5")));
}

TEST_F(RecordFile, ReplacesAnOlderFileCompletely) {
  write("a.h5");
  std::ofstream(path("b.h5")) << std::string(1 << 20, 'x');
  write("b.h5");
  EXPECT_TRUE(bytes_of(path("a.h5")) == bytes_of(path("b.h5")));
}

TEST_F(RecordFile, HoldsTheIdentityItReturns) {
  const std::string identity = write("a.h5");
  EXPECT_EQ(identity.size(), 64u);
  const auto stored = record_identity(path("a.h5"));
  ASSERT_TRUE(stored.ok()) << stored.error().text();
  EXPECT_EQ(*stored, identity);
}

TEST_F(RecordFile, ChangesItsIdentityWithAnyValue) {
  std::vector<std::string> seen{write("a.h5")};
  const auto changed = [&](const char* what) {
    seen.push_back(write("b.h5"));
    for (std::size_t i = 0; i + 1 < seen.size(); ++i) EXPECT_NE(seen[i], seen.back()) << what;
  };
  Record& r = scan_.record;
  r.scan = "other";
  changed("title");
  r.what_json += " ";
  changed("what");
  r.inputs[1].pose[3] += 1e-12;
  changed("pose");
  r.source[3].row += 1;
  changed("source row");
  r.drop[5] = 1;
  changed("drop");
  scan_.mesh.positions[9].z += 0.5;
  changed("position");
  std::swap(scan_.mesh.patch.front(), scan_.mesh.patch.back());
  changed("patch");
  r.counters[0].value += 1;
  changed("counter");
  r.notes.push_back("");
  changed("notes");
  r.outputs[0].second[0] = 'z';
  changed("outputs");
}

TEST_F(RecordFile, TakesAnEmptyMesh) {
  scan_.mesh = {};
  const Mesh none;
  scan_.record = {};
  scan_.record.mesh = &none;
  const std::string identity = write("empty.h5");
  const auto stored = record_identity(path("empty.h5"));
  ASSERT_TRUE(stored.ok()) << stored.error().text();
  EXPECT_EQ(*stored, identity);
}

TEST_F(RecordFile, NamesThePathThatCannotBeWritten) {
  std::ofstream(path("plain")) << "x";
  for (const std::string& bad : {path("missing/record.h5"), path("plain/record.h5")}) {
    const auto identity = write_record(scan_.record, bad);
    ASSERT_FALSE(identity.ok());
    EXPECT_EQ(identity.error().code, Code::IoFailed);
    EXPECT_EQ(identity.error().where, bad);
    EXPECT_NE(identity.error().message.find("irectory"), std::string::npos) << identity.error().message;
  }
}

TEST_F(RecordFile, RefusesArraysThatDoNotBelongTogether) {
  scan_.record.vertex_row.pop_back();
  const auto identity = write_record(scan_.record, path("a.h5"));
  ASSERT_FALSE(identity.ok());
  EXPECT_EQ(identity.error().code, Code::Internal);
  EXPECT_FALSE(fs::exists(path("a.h5")));
}

/// Runs in a child process. A limit on the size of files stands for the full disk: the library's writes fail half-way
/// in the same manner.
[[noreturn]] void write_under_size_limit(Record record, const std::string& path) {
  for (std::uint32_t n = 0; n < 300000; ++n) record.points.push_back(Vec3{0.1 * n, 0.7 * n * n, -0.3 * n});
  record.source.resize(record.points.size());
  record.bins.resize(record.points.size());
  record.drop.resize(record.points.size());
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit{};
  limit.rlim_cur = limit.rlim_max = 100000;
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const auto identity = write_record(record, path);
  if (identity.ok() || identity.error().code != Code::IoFailed || fs::exists(path)) std::exit(1);
  std::fprintf(stderr, "%s\n", identity.error().text().c_str());
  std::exit(0);
}

TEST_F(RecordFile, LeavesNothingAndExitsCleanlyWhenTheDiskIsFull) {
  const std::string line = "^[^\n]*full.h5: HDF5 could not [^\n]*: File too large\n$";
  EXPECT_EXIT(write_under_size_limit(scan_.record, path("full.h5")), testing::ExitedWithCode(0), line);
}

TEST_F(RecordFile, ReadBackAndWrittenAgainIsTheSameFile) {
  Record& r = scan_.record;
  r.stray_rows = {3, 5};
  r.patch_fits = {{0, 12, 0.5, 0.1, 0.05, -0.01, 0.5, 0.25}, {1, 7, 1e-300, 0, 0, 0, 0, 0}};
  r.worst = {{{1, 2, 3}, -0.5, {ViewId{2}, 1ull << 40}, 1, true}, {{4, 5, 6}, 0.25, {ViewId{0}, 3}, 0, false}};
  r.worst_interior = {r.worst[1]};
  r.histogram.assign(130, 4);
  r.note_kinds = {NoteKind::Warning, NoteKind::Output};
  r.counters.push_back({"verify", "of a stage without a version", 0.1, false});
  for (std::size_t v = 0; v < scan_.mesh.positions.size(); ++v) {
    r.vertex_error.push_back(static_cast<float>(v));
    r.vertex_error_rms.push_back(0.5f);
  }
  const std::string identity = write("a.h5");
  auto stored = read_record(path("a.h5"));
  ASSERT_TRUE(stored.ok()) << stored.error().text();
  EXPECT_EQ(stored->identity, identity);
  EXPECT_EQ(stored->record.source, r.source);
  EXPECT_EQ(stored->mesh->positions, scan_.mesh.positions);
  stored->record.description_text = r.description_text;
  const auto again = write_record(stored->record, path("b.h5"));
  ASSERT_TRUE(again.ok()) << again.error().text();
  EXPECT_EQ(*again, identity);
  EXPECT_TRUE(bytes_of(path("a.h5")) == bytes_of(path("b.h5")));
}

TEST_F(RecordFile, OfAnEarlierLayoutIsNotReadBack) {
  const auto kept = read_record(std::string(SCANMILL_SOURCE_DIR) + "/tests/provenance/kept/record-1.h5");
  ASSERT_FALSE(kept.ok());
  EXPECT_EQ(kept.error().code, Code::BadInput);
}

TEST_F(RecordFile, SaysWhatIsWrongWithAForeignFile) {
  const auto missing = record_identity(path("none.h5"));
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().code, Code::IoFailed);
  EXPECT_EQ(missing.error().where, path("none.h5"));
  std::ofstream(path("text.h5")) << "not hdf5";
  const auto foreign = record_identity(path("text.h5"));
  ASSERT_FALSE(foreign.ok());
  EXPECT_EQ(foreign.error().code, Code::BadInput);
  write("a.h5");
  fs::resize_file(path("a.h5"), fs::file_size(path("a.h5")) / 2);
  EXPECT_FALSE(record_identity(path("a.h5")).ok());
}

}  // namespace
}  // namespace scanmill::provenance
