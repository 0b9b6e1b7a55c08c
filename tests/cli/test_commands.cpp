// SPDX-License-Identifier: Apache-2.0
// The program as a user types it.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "document/document.hpp"

namespace scanmill {
namespace {

class Program : public testing::Test {
 protected:
  struct Seen {
    int code = -1;
    std::string out, err;
  };
  void SetUp() override {
    root_ = testing::TempDir() + "scanmill-cli-" + testing::UnitTest::GetInstance()->current_test_info()->name() + "-" +
            std::to_string(getpid());
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_ + "/archive");
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  Seen run(const std::string& arguments) const {
    const int status =
        std::system(("cd '" + root_ + "' && '" SCANMILL_PROGRAM "' " + arguments + " >out.txt 2>err.txt").c_str());
    return {WEXITSTATUS(status), text("out.txt"), text("err.txt")};
  }
  std::string text(const std::string& name) const {
    std::ifstream file(root_ + "/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write(const std::string& name, const std::string& content) const {
    std::ofstream(root_ + "/" + name) << content;
  }
  /// A bent sheet of 60 x 60 points, 0.5 mm apart.
  void write_sheet(const std::string& name) const {
    std::ofstream file(root_ + "/" + name);
    for (int i = 0; i < 60; ++i)
      for (int j = 0; j < 60; ++j) file << i * 0.5 << ' ' << j * 0.5 << ' ' << i * j * 0.001 << '\n';
  }
  std::string root_;
};

TEST_F(Program, NamesTheNearestForUnknownWords) {
  Seen seen = run("runn job.yaml");
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.err.find("unknown command runn; allowed run, init, check"), std::string::npos) << seen.err;
  EXPECT_NE(seen.err.find("nearest run"), std::string::npos) << seen.err;
  seen = run("run job.yaml --onyl x");
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.err.find("unknown option --onyl; nearest --only"), std::string::npos) << seen.err;
  seen = run("mesh a.ply -o b.stl --bin-m 3");
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.err.find("nearest --bin-mm"), std::string::npos) << seen.err;
  for (const char* words : {"", "run", "run a b", "reduce a.ply", "run j --threads 0", "run j --progress loud",
                            "run j --memory x", "schema plane"}) {
    seen = run(words);
    EXPECT_EQ(seen.code, 2) << words;
    EXPECT_FALSE(seen.err.empty()) << words;
  }
}

TEST_F(Program, StageOptionsAreJudgedLikeTheJob) {
  for (const auto& [option, sentence] : std::initializer_list<std::pair<const char*, const char*>>{
           {"--bin-mm 0", "lattice.bin_mm: found 0; allowed (0, "},
           {"--bin-mm 1 --range-bins 3", "grow.range_bins: found 3; allowed (0, 2.5]"},
           {"--bin-mm 1 --engine star", "grow.engine: found star; allowed stars, front; nearest stars"},
           {"--bin-mm 1 --seed 1,2", "seeds.points: found a list; allowed three numbers"},
           {"--bin-mm 1 --target-points 100", "exclude each other"},
           {"--range-bins 2", "lattice: found no bin size"}}) {
    const Seen seen = run(std::string("mesh a.xyz -o b.stl ") + option);
    EXPECT_EQ(seen.code, 2) << option;
    EXPECT_NE(seen.err.find(sentence), std::string::npos) << option << "\n" << seen.err;
    EXPECT_EQ(seen.err.rfind("command line: ", 0), 0u) << seen.err;
  }
}

TEST_F(Program, ShowsVersionAndHelp) {
  EXPECT_EQ(run("--version").code, 0);
  EXPECT_NE(run("--version").out.find("openvdb"), std::string::npos);
  EXPECT_EQ(run("--version --json").out.rfind("{\"type\":\"version\"", 0), 0u) << run("--version --json").out;
  EXPECT_NE(run("mesh --help").out.find("--min-neighbour-distance"), std::string::npos);
}

TEST_F(Program, RunsAJobAndResumes) {
  write_sheet("archive/sheet.xyz");
  write("job.yaml", "scanmill: 1\narchive: archive\nsettle_s: 0\nlattice: {bin_mm: 2}\n");
  EXPECT_EQ(run("check job.yaml").code, 0);
  Seen seen = run("run job.yaml --threads 2");
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_NE(seen.out.find("sheet: done | job.out/scans/sheet/mesh.stl | job.out/scans/sheet/record.h5 | "
                          "job.out/scans/sheet/report.html | "),
            std::string::npos)
      << seen.out;
  EXPECT_NE(seen.out.find("1 scan: 0 unchanged, 1 done, 0 failed, 0 quarantined | gates: 0 | 00:00:"),
            std::string::npos)
      << seen.out;
  const std::string mesh = text("job.out/scans/sheet/mesh.stl"), record = text("job.out/scans/sheet/record.h5");
  seen = run("run job.yaml --explain --json");
  EXPECT_EQ(seen.code, 0);
  EXPECT_NE(seen.out.find(R"("type":"explain","name":"sheet","verb":"skipped")"), std::string::npos) << seen.out;
  EXPECT_NE(seen.out.find(R"("type":"summary")"), std::string::npos) << seen.out;
  EXPECT_EQ(run("run job.yaml --out other --threads 1 --quiet").code, 0);
  EXPECT_EQ(text("other/scans/sheet/mesh.stl"), mesh);
  EXPECT_EQ(text("other/scans/sheet/record.h5"), record);
}

TEST_F(Program, CheckReportsAllProblemsWithPlaces) {
  write("job.yaml", "scanmill: 1\nlattice: {bin_m: 1}\nunits: mile\n");
  const Seen seen = run("check job.yaml");
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.err.find("job.yaml:2:11: lattice.bin_m: unknown key"), std::string::npos) << seen.err;
  EXPECT_NE(seen.err.find("job.yaml:3:8: units: found mile"), std::string::npos) << seen.err;
}

TEST_F(Program, RemovesWhatADeadRunLeftBehind) {
  write_sheet("archive/sheet.xyz");
  write("job.yaml", "scanmill: 1\narchive: archive\nsettle_s: 0\nlattice: {bin_mm: 2}\n");
  EXPECT_EQ(run("run job.yaml --out out").code, 0);
  std::filesystem::create_directories(root_ + "/out/scans/.sheet.1");
  EXPECT_EQ(run("run job.yaml --out out").code, 0);
  EXPECT_FALSE(std::filesystem::exists(root_ + "/out/scans/.sheet.1"));
}

/// A bench document with all its CPU times changed by a factor.
std::string with_cpu_times(const std::string& text, double factor) {
  auto tree = document::parse_json(text, "bench.json");
  EXPECT_TRUE(tree.ok()) << text;
  if (!tree) return text;
  for (document::Node& stage : tree->find("stages")->items())
    for (document::Node::Entry& entry : stage.find("cpu_s")->entries())
      entry.value = document::Node(entry.value.as_number() * factor);
  return document::to_json(*tree);
}

TEST_F(Program, BenchMeasuresAllStagesAndTellsSlowdowns) {
  write_sheet("sheet.xyz");
  Seen seen = run("bench --file sheet.xyz --bin-mm 2 --repeat 1 --threads 1 --out base.json");
  ASSERT_EQ(seen.code, 0) << seen.err;
  for (const char* word : {"reduce", "mesh", "smooth", "feature", "quality", "verify", "3,600 points"})
    EXPECT_NE(seen.out.find(word), std::string::npos) << word << "\n" << seen.out;
  const std::string base = text("base.json");
  EXPECT_NE(base.find("\"scanmill_bench\": 1"), std::string::npos);
  // Times ten, so that no noise of a busy machine can look like a slowdown.
  write("slow.json", with_cpu_times(base, 10));
  seen = run("bench --file sheet.xyz --bin-mm 2 --repeat 1 --threads 1 --against slow.json");
  EXPECT_EQ(seen.code, 0) << seen.err;
  write("fast.json", with_cpu_times(base, 0.1));
  seen = run("bench --file sheet.xyz --bin-mm 2 --repeat 1 --threads 1 --against fast.json --json");
  EXPECT_EQ(seen.code, 4) << seen.out;
  EXPECT_NE(seen.out.find(R"("type":"report","command":"bench")"), std::string::npos) << seen.out;
  EXPECT_NE(seen.out.find("bench.verify: found at least"), std::string::npos) << seen.out;
}

TEST_F(Program, BenchOfOneStageNamesTheOthersAsMissing) {
  write_sheet("sheet.xyz");
  ASSERT_EQ(run("bench --file sheet.xyz --bin-mm 2 --repeat 1 --out base.json").code, 0);
  write("slow.json", with_cpu_times(text("base.json"), 10));
  Seen seen = run("bench optimise --file sheet.xyz --bin-mm 2 --repeat 2 --against slow.json --out two.json");
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_NE(seen.out.find("verify: in the earlier bench only"), std::string::npos) << seen.out;
  const auto two = document::parse_json(text("two.json"), "two.json");
  ASSERT_TRUE(two.ok());
  ASSERT_EQ(two->find("stages")->items().size(), 2u);
  EXPECT_EQ(two->find("stages")->items()[1].find("name")->as_string(), "feature");
  seen = run("bench --file sheet.xyz --bin-mm 3 --repeat 1 --against base.json");
  EXPECT_EQ(seen.code, 2);
  EXPECT_NE(seen.err.find("base.json: was measured on 3,600 points with bins of 2 mm"), std::string::npos) << seen.err;
  EXPECT_EQ(run("bench --repeat 0").code, 2);
  EXPECT_EQ(run("bench --file sheet.xyz --out sheet.xyz").code, 2);
}

}  // namespace
}  // namespace scanmill
