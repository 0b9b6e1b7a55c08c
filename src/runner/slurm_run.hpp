// SPDX-License-Identifier: Apache-2.0
// The books of a run on Slurm: what is wanted, what was handed in, what came of it. Internal to the executor;
// slurm_executor.cpp holds its face, slurm_hand_in.cpp what goes to Slurm, slurm_outcome.cpp what comes back and
// slurm_verdict.cpp what it means, slurm_doubt.cpp what a controller forgot, slurm_waiting.cpp the words for it.
#pragma once
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "base/digest.hpp"
#include "runner/slurm_client.hpp"
#include "runner/slurm_executor.hpp"
#include "runner/slurm_wave.hpp"

namespace scanmill::runner {

inline constexpr double kMostBackOff = 60;                 // s
inline constexpr std::uint64_t kTaskMemory = 96ull << 20;  // the task's own, beside the scan's process

inline double age_s(Moment begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}
inline std::chrono::steady_clock::duration seconds(double count) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(count));
}
inline std::string keys_digest(const document::Node& keys) { return sha256_hex(document::to_canonical_json(keys)); }

class SlurmRun final : public Executor {
 public:
  explicit SlurmRun(SlurmOptions options);
  ~SlurmRun() override;
  Result<void> start(const Order& order) override;
  std::vector<Ended> wait(std::chrono::milliseconds timeout) override;
  const std::vector<Running>& running() const override { return running_; }
  bool is_remote() const override { return true; }
  std::string waits_for() const override { return waits_for_; }
  std::optional<Error> broken() const override { return broken_; }
  void drain() override;
  void stop_all() override;
  void kill_all() override;

 private:
  /// Scans and parts are told apart by one number, which is called a scan's below.
  std::size_t unit_of(const Order& order);
  const ScanEntry& entry_of(std::size_t unit) const { return o_.entry_of(units_[unit]); }

  // What is wanted.
  /// Share of a scan in the time limit of its element.
  double granted(const Wanted& wanted) const;
  void list_running();
  /// The scan comes to its end for this executor.
  void finish(std::size_t scan, Ended ended);
  /// Without a result, and nobody's fault: not begun, or stopped on request.
  void give_back(std::size_t scan);
  void give_back_waiting();
  void fail_scan(std::size_t scan, FailureClass failure, Error error);
  /// Submitted again; `count` of so many times so far, which is said and delays it.
  void again(std::size_t scan, int count, const std::string& why);

  // Handing in.
  void flush();
  void plan_waves(std::uint64_t memory, const std::vector<std::size_t>& scans);
  /// Elements of an array: the job's wish, and what the cluster takes.
  std::size_t most_elements();
  void make_one(const std::vector<std::vector<std::size_t>>& tasks, std::uint64_t memory);
  std::string script_of(const TaskFile& file) const;
  static std::string own_path();
  void submit(Wave& wave);
  void accept(Wave& wave);
  void retry_later(Wave& wave, const std::string& why);

  // When the controller was killed: what it forgot (slurm_doubt.cpp).
  /// The controller is out of reach.
  void doubt_all();
  /// A number of a job that was given to one of ours.
  void know_number(std::uint64_t number);
  /// Elements that began and that Slurm has waiting: it lost their start, and would give their numbers out again.
  void find_forgotten();
  /// Sees to it that the next array gets numbers that no job of ours had: nodes refuse a number that they know.
  void skip_numbers();
  /// An end that may be another one's: submitted again without counting against anything. False: it counts.
  bool excuses(Wanted& wanted, const std::string& end, const std::string& job);
  void tell_of_excused();

  // What is waited for, in words (slurm_waiting.cpp).
  void list_element(const Wave& wave, std::size_t e, const std::map<std::size_t, std::size_t>& place);
  void list_waiting();
  void tell_of_waiting();
  std::string idle_nodes();

  // Taking over.
  /// Waves of a driver that died; their elements wait for scans that are wanted.
  void take_over();
  bool adopt(std::size_t scan, const Wanted& wanted);
  /// Everything wanted at the start has been asked for: elements that nobody wants are of no use.
  void drop_unwanted();

  // What comes of it.
  bool has_submitted() const;
  /// One list of the folder tells of all records and signs of life; on NFS it also brings the cache up to date.
  void read_records(Wave& wave);
  void hear(Element& element, const std::string& path);
  void take(Element& element, std::size_t item, TaskResult result);
  void look();
  void see(Element& element, const QueueRow& row);
  void judge(std::size_t w);
  void judge_element(Wave& wave, std::size_t e);
  /// Whether the element's task shows life though Slurm says that it is over.
  bool lives(const Wave& wave, const Element& element) const;
  /// A held job never starts by itself: one whose launch failed is taken back, one that a person holds is told of.
  void judge_held(Wave& wave, std::size_t e);
  /// The element is over, and these of its scans have no record.
  void resolve(Wave& wave, std::size_t e, JobPhase phase);
  /// What became of the scan that was at work.
  void blame(const Wave& wave, std::size_t e, Wanted& wanted, JobPhase phase, bool begun);
  void lose(Wanted& wanted, const std::string& what);
  /// The program did not come up on the node. Once may be the node; every time is the job's.
  void failed_launch(Wave& wave, std::size_t e, const std::vector<std::size_t>& left, int code);
  /// `all`: cancel what Slurm has of it. Else only what never began: a task that is about to end is left in peace.
  void close(Wave& wave, bool all);

  SlurmOptions o_;
  SlurmClient slurm_;
  struct Place {
    std::size_t wave, element, item;
  };
  std::vector<Wave> waves_;
  std::map<std::pair<std::size_t, std::string>, std::size_t> unit_numbers_;
  std::vector<std::size_t> units_;        // the scan of each
  std::map<std::size_t, Wanted> wanted_;  // by unit
  std::map<std::string, Place> offers_;   // of waves that were taken over, by scan and keys
  std::map<std::size_t, double> grants_;  // time that scans were found to need
  std::vector<Running> running_;
  std::string waits_for_, told_waits_, looked_at_, idle_nodes_;
  struct Excused {
    std::string name, job;  // of the first
    std::size_t count = 0;
  };
  std::map<std::string, Excused> excused_;   // by how they ended
  std::vector<std::string> closed_unheard_;  // names of arrays that were closed while the controller was out of reach
  std::map<std::string, std::size_t> reasons_;  // why elements wait, and how many do
  std::uint64_t highest_number_ = 0;            // of a job of ours
  int vain_tries_ = 0;                          // to submit, since the last that was answered
  std::vector<Ended> ended_;
  std::optional<Error> broken_;
  std::optional<std::size_t> most_elements_;
  std::set<std::string> warned_;
  std::chrono::steady_clock::duration scan_interval_{};
  Moment next_scan_{}, next_look_{}, answered_{}, next_try_{}, next_idle_look_{}, told_{};
  int failed_launches_ = 0;
  bool draining_ = false, stopping_ = false, silent_ = false, started_ = false, took_leftovers_ = false,
       list_changed_ = false, may_repeat_numbers_ = false;
};

}  // namespace scanmill::runner
