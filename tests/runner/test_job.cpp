// SPDX-License-Identifier: Apache-2.0
#include "fake_work.hpp"
#include "runner/glob.hpp"
#include "runner/job.hpp"

namespace scanmill::runner {
namespace {

TEST(Glob, StarCrossesFoldersAndQuestionMarkTakesOne) {
  EXPECT_TRUE(matches("*", "a/b"));
  EXPECT_TRUE(matches("a*c", "abbc"));
  EXPECT_TRUE(matches("*b*b", "abab"));
  EXPECT_TRUE(matches("part-?", "part-7"));
  EXPECT_FALSE(matches("part-?", "part-10"));
  EXPECT_FALSE(matches("a", "ab"));
  EXPECT_FALSE(matches("", "a"));
  EXPECT_TRUE(matches("***", ""));
}

Result<Job> job(const std::string& text, std::vector<std::string> sets = {}) {
  static const FakeWork work;
  return job_from(text, "jobs/j.yaml", sets, work);
}

TEST(JobFrom, TakesPathsFromTheJobFilesFolder) {
  const auto plain = job("scanmill: 1\nlattice: {bin_mm: 1}\n");
  ASSERT_TRUE(plain.ok()) << plain.error().text();
  EXPECT_EQ(plain->archive, "jobs/");
  EXPECT_EQ(job("scanmill: 1\narchive: ../x\n")->archive, "x");
  EXPECT_EQ(job("scanmill: 1\narchive: /abs\n")->archive, "/abs");
}

TEST(JobFrom, ReportsAllProblemsAtOnceWithPlaceAndNearest) {
  const auto broken =
      job("scanmill: 2\narchiv: x\nlattice: {bin_m: 1}\nresources: {threads: 0, memory: lots}\nstrict: 3\n");
  ASSERT_FALSE(broken.ok());
  const std::string text = broken.error().text();
  for (const char* line :
       {"jobs/j.yaml:1:11: scanmill: found 2; allowed 1", "jobs/j.yaml:2:1: archiv: unknown key; allowed",
        "nearest archive", "jobs/j.yaml:3:11: lattice.bin_m: unknown key; allowed bin_mm; nearest bin_mm",
        "jobs/j.yaml:4:22: resources.threads: found 0; allowed [1, 1024]",
        "jobs/j.yaml:4:33: resources.memory: found lots", "jobs/j.yaml:5:9: strict: found 3"})
    EXPECT_NE(text.find(line), std::string::npos) << line << "\n" << text;
}

TEST(JobFrom, ReadsHowScansAreCutIntoBricks) {
  const auto plain = job("scanmill: 1\n");
  ASSERT_TRUE(plain.ok()) << plain.error().text();
  EXPECT_EQ(plain->how.brick.edge_bins, 0);
  const auto full = job("scanmill: 1\nbrick: {edge_bins: 64, pieces: 5, batches: 9}\n");
  ASSERT_TRUE(full.ok()) << full.error().text();
  EXPECT_EQ(full->how.brick.edge_bins, 64);
  EXPECT_EQ(full->how.brick.pieces, 5);
  EXPECT_EQ(full->how.brick.batches, 9);
  EXPECT_TRUE(job("scanmill: 1\nbrick: {edge_bins: auto}\n").ok());
  for (const char* edge : {"0", "100", "512", "much", "1.5"}) {
    const auto refused = job(std::string("scanmill: 1\nbrick: {edge_bins: ") + edge + "}\n");
    ASSERT_FALSE(refused.ok()) << edge;
    EXPECT_NE(refused.error().text().find("brick.edge_bins: found"), std::string::npos) << refused.error().text();
  }
}

TEST(JobFrom, ReadsHowWorkIsHandedToTheCluster) {
  const auto full =
      job("scanmill: 1\nexecutor: slurm\ncluster: {partition: batch, account: 42, extra: --constraint=avx2 --nice=10,\n"
          "  wrap: [apptainer, exec, 'my image.sif'], time: 30m, element_time: 2m, poll_s: 5, chunk: 100}\n");
  ASSERT_TRUE(full.ok()) << full.error().text();
  const ClusterKeys& keys = full->how.cluster;
  EXPECT_TRUE(full->how.on_cluster);
  EXPECT_EQ(keys.partition, "batch");
  EXPECT_EQ(keys.account, "42");
  EXPECT_EQ(keys.extra, (std::vector<std::string>{"--constraint=avx2", "--nice=10"}));
  EXPECT_EQ(keys.wrap, (std::vector<std::string>{"apptainer", "exec", "my image.sif"}));
  EXPECT_EQ(keys.time_s, 1800);
  EXPECT_EQ(keys.element_s, 120);
  EXPECT_EQ(keys.poll_s, 5);
  EXPECT_EQ(keys.chunk, 100);
  const auto wrong =
      job("scanmill: 1\nexecutor: slrm\ncluster:\n  partition: [a]\n  tme: 3m\n  time: soon\n  wrap: {}\n  chunk: 0\n");
  ASSERT_FALSE(wrong.ok());
  for (const char* line : {":2:11: executor: found slrm; allowed inline, local, slurm; nearest slurm",
                           ":4:14: cluster.partition", ":5:3: cluster.tme: unknown key", "nearest time",
                           ":6:9: cluster.time: found soon", ":7:9: cluster.wrap", ":8:10: cluster.chunk"})
    EXPECT_NE(wrong.error().text().find(line), std::string::npos) << line << "\n" << wrong.error().text();
}

TEST(JobFrom, IgnoresExtensionsAndNothingElse) {
  EXPECT_TRUE(job("scanmill: 1\nx-note: {any: thing}\n").ok());
  EXPECT_FALSE(job("scanmill: 1\ny-note: 1\n").ok());
  EXPECT_FALSE(job("- 1\n").ok());
  EXPECT_FALSE(job("").ok());
}

TEST(JobFrom, LaterOverridesWinAndSetsWinOverAll) {
  const std::string text =
      "scanmill: 1\nlattice: {bin_mm: 1}\noverrides:\n  - {scans: 'a*', lattice: {bin_mm: 2}}\n  - {scans: [ab, c], "
      "lattice: {bin_mm: 3}}\n";
  const FakeWork work;
  const auto bin = [&](const Job& j, const char* scan) {
    return what_of(j, scan, work).find("lattice")->find("bin_mm")->as_number();
  };
  const auto plain = job(text);
  ASSERT_TRUE(plain.ok()) << plain.error().text();
  EXPECT_EQ(bin(*plain, "z"), 1);
  EXPECT_EQ(bin(*plain, "aa"), 2);
  EXPECT_EQ(bin(*plain, "ab"), 3);
  const auto set = job(text, {"lattice.bin_mm=0.5", "resources.threads=2", "resources.memory=1G", "strict=true"});
  ASSERT_TRUE(set.ok()) << set.error().text();
  EXPECT_EQ(bin(*set, "ab"), 0.5);
  EXPECT_EQ(set->how.threads, 2);
  EXPECT_EQ(set->how.memory, 1ull << 30);
  EXPECT_TRUE(set->how.strict);
}

TEST(JobFrom, NamesTheCommandLineAsPlaceOfBadSets) {
  for (const std::string set : {"lattice.bin_m=1", "nokey", "resources.threads=0", "foo=1"}) {
    const auto refused = job("scanmill: 1\n", {set});
    ASSERT_FALSE(refused.ok()) << set;
    EXPECT_EQ(refused.error().text().rfind("command line: ", 0), 0u) << refused.error().text();
  }
}

TEST(Glob, MatchesNamesAsTheFilesAreCalled) {
  EXPECT_TRUE(matches("%C3%96l*", "%C3%96lfilter"));
  EXPECT_TRUE(matches("Öl*", "%C3%96lfilter"));
  EXPECT_TRUE(matches("a b", "a%20b"));
  EXPECT_FALSE(matches("Ol*", "%C3%96lfilter"));
  EXPECT_TRUE(matches("50%", "50%"));
}

TEST(JobFrom, ReadsHowToRun) {
  const auto read =
      job("scanmill: 1\nsettle_s: 5\nexecutor: inline\nretry: {transient: 4, wait_s: 0.5}\n"
          "resources: {until: '05:30', disk: 2G, scan_time_limit: 90m}\n");
  ASSERT_TRUE(read.ok()) << read.error().text();
  EXPECT_EQ(read->how.settle_s, 5);
  EXPECT_TRUE(read->how.in_this_process);
  EXPECT_EQ(read->how.retry_transient, 4);
  EXPECT_EQ(read->how.retry_internal, 1);
  EXPECT_EQ(read->how.retry_wait_s, 0.5);
  EXPECT_EQ(read->how.until_minute, 330);
  EXPECT_EQ(read->how.disk, 2ull << 30);
  EXPECT_EQ(read->how.scan_time_limit_s, 5400);
  for (const std::string line : {"resources: {until: '5:3'}", "resources: {until: '24:00'}", "resources: {disk: 0}",
                                 "resources: {scan_time_limit: soon}", "retry: {often: 3}", "settle_s: -1"})
    EXPECT_FALSE(job("scanmill: 1\n" + line + "\n").ok()) << line;
}

TEST(JobFrom, OverridesMustNameScansAndMayNotChangeDiscovery) {
  EXPECT_FALSE(job("scanmill: 1\noverrides: [{lattice: {bin_mm: 1}}]\n").ok());
  EXPECT_FALSE(job("scanmill: 1\noverrides: [{scans: a, views: []}]\n").ok());
  EXPECT_FALSE(job("scanmill: 1\noverrides: [{scans: a, archive: b}]\n").ok());
  EXPECT_FALSE(job("scanmill: 1\noverrides: 3\n").ok());
}

}  // namespace
}  // namespace scanmill::runner
