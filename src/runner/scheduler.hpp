// SPDX-License-Identifier: Apache-2.0
// The middle of a run: takes scans from the worklist to the executor and decides what becomes of those that fail.
#pragma once
#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runner/executor.hpp"
#include "runner/job.hpp"
#include "runner/journal.hpp"
#include "runner/run_view.hpp"
#include "runner/worklist.hpp"

namespace scanmill::runner {

class Scheduler {
 public:
  struct Parts {
    const RunOptions& options;
    const How& how;
    const OutputTree& tree;
    const Selection& selection;
    const ScanMaker& maker;
    Work& work;
    Console& console;
    Stop& stop;
    RunReport& report;  // one entry per scan of the selection, in its order, first
    Quarantine& quarantine;
    Journal* journal;  // nullptr in a dry run
    Executor& executor;
    std::uint64_t memory = 0;    // to share out; 0: no cap
    bool one_at_a_time = false;  // each gets everything
    std::function<int()> save;   // run.json; the exit code
    std::function<void(const Error&)> complain;
  };
  explicit Scheduler(Parts parts);
  /// Every scan unchanged, done, failed or put off. The exit code as far as it is not told by the scans' fates.
  int run();

 private:
  using Clock = std::chrono::steady_clock;

  void sort_out();
  void leave_quarantine(const ScanEntry& entry);
  void show(ScanEntry& entry);
  void put_on_list(std::size_t scan);
  void put_next_wave(std::size_t scan);
  bool is_at_work(std::size_t scan) const;
  void begin_again(std::size_t scan, ScanEntry& entry, bool at_once);
  bool may_heal(std::size_t scan, const std::string& lost);
  void tell_of_cut(std::size_t scan);
  double seconds_of_cut(std::size_t scan, const Ended& ended);
  void end_part(const WorkItem& item, Ended&& ended);
  std::optional<Error> lack_for_parts(std::size_t scan, const CutForecast& forecast) const;
  WorkItem take_from_work(const Order& order);
  void tell_of_deadline();
  void tell_of_waits();
  void listen();
  void start_ready();
  bool may_start(const WorkItem& item, const Order& order);
  bool settles(WorkItem& item);
  void leave_for_later(std::size_t scan, const std::string& why);
  void end(Ended&& ended);
  void keep_result(ScanEntry& entry) const;
  void take_over_death(Ended& ended, ScanEntry& entry) const;
  bool goes_again(WorkItem item, const Ended& ended, const ScanEntry& entry);
  void finish_scan(const WorkItem& item, const Ended& ended, const std::string& fingerprint);
  void note_end(const WorkItem& item, const Ended& ended, bool again);
  void keep_state();
  void put_off(const std::string& why);
  std::string lack_of_space(const WorkItem& item) const;
  void recall_memory();
  Room room() const;
  RunPicture picture() const;
  double share_of(const WorkItem& item) const;
  double bytes_of_parts() const;
  std::string at_work_text(bool queued_too) const;
  const std::string& name(std::size_t scan) const { return names_[scan]; }

  Parts p_;
  Worklist list_;
  RunView view_;
  std::vector<std::string> names_;
  std::vector<WorkItem> at_work_;
  /// A scan whose parts are made first.
  struct CutState {
    std::vector<std::vector<std::string>> waves;
    std::vector<std::uint8_t> whole;
    std::size_t next = 0;     // wave
    std::size_t left = 0;     // parts of the wave before
    std::uint64_t bytes = 0;  // of the scan
    std::optional<ScanEntry> failed;
    std::string fingerprint;
    bool told = false;   // that it is cut
    bool idle = false;   // its parts are not needed
    bool again = false;  // from the first wave on, once nothing of the scan is at work
    int passing = 0;     // faults so far that may pass
    Clock::time_point not_before{};
    std::vector<double> cpu;          // per wave and, last, of the scan itself, of 1; empty: not known yet
    std::vector<std::uint8_t> found;  // per wave: an earlier run made it
    double share(std::size_t wave) const;
  };
  std::map<std::size_t, CutState> cut_;
  std::map<std::size_t, Clock::time_point> cut_began_;
  std::map<std::pair<std::size_t, std::string>, int> lost_;  // how often a part was found lost or damaged in this run
  std::map<std::size_t, PartCount> parts_;                   // of scans that are cut, until they are done themselves
  std::vector<std::uint64_t> remembered_;                    // memory that a scan was found to need
  Clock::time_point began_ = Clock::now(), saved_{}, asked_{}, space_checked_{}, stop_at_{};
  double save_took_ = 0;
  std::uint64_t bytes_all_ = 0, bytes_done_ = 0;
  double core_seconds_ = 0;  // of what is done
  double bytes_found_ = 0;   // of bytes_done_, made by earlier runs
  std::uint64_t space_floor_ = 0;
  std::optional<std::int64_t> deadline_;  // seconds since 1970
  std::string remark_;
  bool draining_ = false;
  int code_ = 0;
};

}  // namespace scanmill::runner
