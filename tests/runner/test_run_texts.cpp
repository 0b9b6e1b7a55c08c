// SPDX-License-Identifier: Apache-2.0
// junit.xml, trace.tsv, scanmill.prom and the step summary, read back by readers that know nothing of who wrote them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cctype>
#include <fstream>
#include <map>
#include <set>

#include "base/text.hpp"
#include "run_sample.hpp"
#include "runner/advice.hpp"
#include "runner/run_texts.hpp"

namespace scanmill::runner {
namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// What python's XML parser finds: a line per test case, "name|child tag|type|message|text", repr of each.
std::string python_reads(const std::string& xml) {
  const std::string path = testing::TempDir() + "scanmill-junit-" + std::to_string(getpid());
  std::ofstream(path + ".xml", std::ios::binary) << xml;
  const std::string program =
      "import sys,xml.etree.ElementTree as e\n"
      "r=e.parse(sys.argv[1]).getroot()\n"
      "s=r.find(\"testsuite\")\n"
      "print(*[s.get(k) for k in (\"tests\",\"failures\",\"errors\",\"skipped\",\"timestamp\",\"name\")],sep=\"|\")\n"
      "for c in s.iter(\"testcase\"):\n"
      "  for k in list(c) or [e.Element(\"passed\")]:\n"
      "    print(*map(ascii,(c.get(\"name\"),k.tag,k.get(\"type\"),k.get(\"message\"),k.text)),sep=\"|\")\n";
  const int status = std::system(
      ("'" + std::string(PYTHON3) + "' -c '" + program + "' '" + path + ".xml' > '" + path + ".txt'").c_str());
  std::ifstream file(path + ".txt");
  std::string text((std::istreambuf_iterator<char>(file)), {});
  unlink((path + ".xml").c_str());
  unlink((path + ".txt").c_str());
  return status == 0 ? text : "no XML";
}

TEST(JunitXml, SaysWhatHappenedToEveryScan) {
  const std::string read = python_reads(junit_xml(sample_run()));
  EXPECT_TRUE(read.starts_with("10|2|4|2|2026-01-31T22:15:00|night <&>.yaml\n")) << read;
  for (const char* part :
       {"'same'|'passed'|None", "'done'|'system-out'|None|None|'one view is missing",
        "'cleaned & rejected'|'failure'|'gate'|'verify.max_error_mm: found 0.5 mm, allowed 0.1 mm'|\"class: gate",
        "'stale'|'error'|'internal'|'unexpected: surprise'|\"class: internal\\nstage: reduce\\nfound: unexpected",
        "'hungry'|'error'|'resource'", "'full'|'error'|'transient'", "'cut'|'error'|'cancelled'",
        "'held'|'skipped'|None|'quarantined: held/v2.ply: byte 81920", "'later'|'skipped'|None|'not reached'",
        "what to do: Raise resources.memory", "again: scanmill run job.yaml --only stale\\nlog: logs/stale.log"})
    EXPECT_TRUE(contains(read, part)) << part << "\nin\n" << read;
  EXPECT_FALSE(contains(read, "gone"));
}

TEST(JunitXml, IsSoundWhateverNamesHold) {
  const std::string read = python_reads(junit_xml(sample_run()));
  // Line feed and tab come back; what XML cannot hold, and what would hide, is shown.
  EXPECT_TRUE(contains(read, R"('"><b>&amp;|`*]]>\n\tx\\x0d\\x01\\xff\\u{202e}\\x1b[31m\\end'|'failure'|'bad_input'|)"))
      << read;
  RunReport run;
  for (int byte = 0; byte < 256; ++byte)
    run.scans.push_back(failed_entry("a" + std::string(1, static_cast<char>(byte)) + "b", ScanFate::Failed,
                                     fail(Code::Internal, std::string(2, static_cast<char>(byte)))));
  run.host = run.archive = run.version = kEvil;
  EXPECT_EQ(lines_of(python_reads(junit_xml(run))).size(), 258u);
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells{""};
  for (const char c : line)
    if (c == '\t')
      cells.emplace_back();
    else
      cells.back() += c;
  return cells;
}

TEST(TraceTsv, HasARowPerScanAndAColumnPerStage) {
  const RunReport run = sample_run();
  const std::vector<std::string> lines = lines_of(trace_tsv(run));
  ASSERT_EQ(lines.size(), run.scans.size() + 2);  // names on top, a line feed at the end
  EXPECT_EQ(lines[0],
            "name\tstate\tclass\tattempts\tstarted\tended\tseconds\tcpu_seconds\tpeak_memory_bytes\tpoints\ttriangles\t"
            "reduce_seconds\tclean_seconds\tmesh_seconds\tverify_seconds");
  EXPECT_EQ(lines[1],
            "done\tdone\t\t1\t2026-01-31T22:15:00Z\t2026-01-31T22:15:02Z\t2.000000\t3.500000\t104857600\t30000\t6240\t"
            "0.250000\t\t1.500000\t");
  for (std::size_t k = 1; k + 1 < lines.size(); ++k) EXPECT_EQ(cells_of(lines[k]).size(), 15u) << lines[k];
  EXPECT_EQ(cells_of(lines[4])[0], R"("><b>&amp;|`*]]>\n\tx\x0d\x01\xff\u{202e}\x1b[31m\\end)");
  EXPECT_EQ(cells_of(lines[5])[2], "internal");
}

/// Prometheus text format, read strictly: comment lines in front of their samples, names and labels in their alphabets,
/// escapes closed, values numbers, no series twice. Series to value; the first fault in `fault`.
std::map<std::string, double> read_metrics(const std::string& text, std::string& fault) {
  std::map<std::string, double> series;
  std::set<std::string> helped, typed;
  std::string family;
  const auto is_name = [](const std::string& word) {
    return !word.empty() && !std::isdigit(static_cast<unsigned char>(word[0])) &&
           word.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789") == std::string::npos;
  };
  if (text.empty() || text.back() != '\n') fault = "no line feed at the end";
  for (const std::string& line : lines_of(text)) {
    if (line.empty()) continue;
    if (line.starts_with("# ")) {
      const auto words = words_of(line);
      const std::string name(words.size() > 3 ? words[2] : "");
      if (!is_name(name)) fault = "name in " + line;
      if (words[1] == "HELP" && !helped.insert(name).second) fault = "HELP twice: " + line;
      if (words[1] == "TYPE" && (!typed.insert(name).second || helped.count(name) == 0 || words[3] != "gauge"))
        fault = "TYPE: " + line;
      family = name;
      continue;
    }
    std::size_t at = line.find('{');
    if (at == std::string::npos || line.substr(0, at) != family || typed.count(family) == 0) fault = "sample: " + line;
    for (++at; at < line.size() && line[at - 1] != '}'; ++at) {
      const std::size_t equals = line.find("=\"", at);
      if (equals == std::string::npos || !is_name(line.substr(at, equals - at)))
        return fault = "label: " + line, series;
      for (at = equals + 2; at < line.size() && line[at] != '"'; ++at)
        if (line[at] == '\\' && std::string_view("\\\"n").find(line[++at]) == std::string_view::npos)
          fault = "escape: " + line;
      ++at;
      if (at >= line.size() || (line[at] != ',' && line[at] != '}')) return fault = "labels: " + line, series;
    }
    const auto value = at < line.size() && line[at] == ' ' ? parse_number(line.substr(at + 1)) : std::nullopt;
    if (!value) return fault = "value: " + line, series;
    if (!series.emplace(line.substr(0, at), *value).second) fault = "twice: " + line;
  }
  return series;
}

TEST(PrometheusText, IsSoundAndHoldsTheFigures) {
  std::string fault;
  auto series = read_metrics(prometheus_text(sample_run(), ""), fault);
  EXPECT_EQ(fault, "");
  const auto value = [&](const std::string& name, const std::string& more = "") {
    const auto at = series.find(name + "{job_file=\"night <&>.yaml\",out=\"/srv/meshes\"" + more + "}");
    return at == series.end() ? -1 : at->second;
  };
  EXPECT_EQ(value("scanmill_run_scans", ",state=\"done\""), 2);
  EXPECT_EQ(value("scanmill_run_scans", ",state=\"stale\""), 1);
  EXPECT_EQ(value("scanmill_run_scans", ",state=\"vanished\""), 1);
  EXPECT_EQ(value("scanmill_run_failures", ",class=\"resource\""), 1);
  EXPECT_EQ(value("scanmill_run_failures", ",class=\"internal\""), 1);
  EXPECT_EQ(value("scanmill_run_failures", ",class=\"bad_input\""), 1);  // what is quarantined did not fail tonight
  EXPECT_EQ(value("scanmill_run_scans_rejected"), 1);
  EXPECT_EQ(value("scanmill_run_exit_code"), 3);
  EXPECT_EQ(value("scanmill_run_duration_seconds"), 3600);
  EXPECT_EQ(value("scanmill_run_cpu_seconds"), 7);
  EXPECT_EQ(value("scanmill_run_stage_seconds", ",stage=\"mesh\""), 3.5);
  EXPECT_EQ(value("scanmill_run_points"), 60000);
  EXPECT_EQ(value("scanmill_run_scans_per_hour"), 2);
  EXPECT_EQ(value("scanmill_run_end_timestamp_seconds"), 1769901300);
  EXPECT_EQ(value("scanmill_last_success_timestamp_seconds"), -1);
  EXPECT_EQ(value("scanmill_build_info", ",version=\"0.1.0\""), 1);
}

TEST(PrometheusText, KeepsTheTimeOfTheLastSuccess) {
  RunReport run = sample_run();
  run.exit_code = 0;
  run.job_path = run.out = kEvil;
  const std::string good = prometheus_text(run, "");
  run.exit_code = 3;
  run.ended = "2026-02-28T23:15:00Z";
  const std::string bad = prometheus_text(run, good);
  std::string fault;
  for (const std::string& text : {good, bad, prometheus_text(run, bad)}) {
    double last = 0;
    for (const auto& [name, value] : read_metrics(text, fault))
      if (name.starts_with("scanmill_last_success")) last = value;
    EXPECT_EQ(fault, "") << text;
    EXPECT_EQ(last, 1769901300) << text;
  }
  EXPECT_EQ(unix_seconds("1970-01-01T00:00:00Z"), 0);
  EXPECT_FALSE(unix_seconds("").has_value());
  EXPECT_FALSE(unix_seconds("2026-02-28 23:15").has_value());
}

TEST(StepSummary, TellsWhatToDoWithoutMarkupFromNames) {
  const std::vector<WorseScan> worse{{kEvil, {{"greatest fit error", "mm", 0.25, 0.5}}, {"verify.rms_mm: found 2"}}};
  const std::string text = step_summary(sample_run(), worse);
  for (const char* part :
       {"## scanmill night &#60;&#38;&#62;.yaml", "| 1 | 2 | 4 | 1 | 1 | 1 | 01:00:00 | 3 |", "Raise resources.memory",
        "### Rejected by a gate", "0.25 | 0.5 |", "kept | failed |", "<code>scanmill run job.yaml --only stale</code>"})
    EXPECT_TRUE(contains(text, part)) << part << "\nin\n" << text;
  EXPECT_FALSE(contains(text, "<b>"));
  EXPECT_FALSE(contains(text, "\x1b"));
  EXPECT_FALSE(contains(text, "\xff"));
  for (const std::string& line : lines_of(text)) {
    if (!line.starts_with("|")) continue;
    const auto bars = std::count(line.begin(), line.end(), '|');
    EXPECT_TRUE(bars == 9 || bars == 6 || bars == 5 || bars == 3) << line;
  }
  RunReport many;
  for (int k = 0; k < 5000; ++k)
    many.scans.push_back(failed_entry("scan", ScanFate::Failed, fail(Code::BadInput, std::string(9000, 'x'))));
  EXPECT_LT(step_summary(many, {}).size(), 200000u);
  EXPECT_TRUE(contains(step_summary(many, {}), "4,950 more stand in report.html"));
}

TEST(AdviceFor, HasASentenceForEveryScanThatNeedsSomebody) {
  for (const ScanEntry& entry : sample_run().scans) {
    const bool fine = (entry.fate == ScanFate::Done && entry.failed_gates.empty()) ||
                      entry.fate == ScanFate::Unchanged || entry.fate == ScanFate::Vanished;
    EXPECT_EQ(advice_for(entry).empty(), fine) << entry.name;
  }
  EXPECT_NE(advice_for(failed_entry("a", ScanFate::Failed, fail(Code::NoSpace, "x", "memory"))),
            advice_for(failed_entry("a", ScanFate::Failed, fail(Code::NoSpace, "x", "/disk"))));
  EXPECT_TRUE(contains(advice_for(failed_entry("a", ScanFate::Stale, fail(Code::IoFailed, "x"))), "last good result"));
}

TEST(VerdictOf, NamesTheWorstFirst) {
  RunReport run = sample_run();
  EXPECT_EQ(verdict_of(run), "4 scans failed, 1 scan rejected by a gate, 2 scans not finished");
  run.exit_code = 130;
  EXPECT_TRUE(verdict_of(run).starts_with("interrupted: 4 scans failed"));
  run.scans.clear();
  run.exit_code = 0;
  EXPECT_EQ(verdict_of(run), "all good");
  run.scans.emplace_back().fate = ScanFate::Quarantined;
  EXPECT_EQ(verdict_of(run), "1 scan quarantined") << "the exit code is 0, and yet not all is good";
}

}  // namespace
}  // namespace scanmill::runner
