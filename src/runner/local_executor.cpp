// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <malloc.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <mutex>

#include "runner/executor.hpp"
#include "runner/machine.hpp"

namespace scanmill::runner {
namespace {

using Clock = std::chrono::steady_clock;
using document::Node;

constexpr auto kTellInterval = std::chrono::milliseconds(100);
// A process makes several scans when they are small: a start and first use of all memory cost 15 ms.
constexpr double kSmallScan_s = 1;
constexpr std::uint64_t kSmallMemory = 256ull << 20;
constexpr int kScansPerWorker = 100;
constexpr auto kIdleAtMost = std::chrono::seconds(1);

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = send(file, text.data(), text.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

/// A line to the driver when a stage begins, and ten times a second.
class PipeProgress final : public Progress {
 public:
  explicit PipeProgress(int file) : file_(file) {}
  void stage(std::string_view name, std::uint64_t done, std::uint64_t total) override {
    const std::unique_lock<std::mutex> guard(mutex_, std::try_to_lock);
    if (!guard.owns_lock()) return;  // another thread is telling
    const auto now = Clock::now();
    if (name == stage_ && now < next_) return;
    stage_ = name;
    next_ = now + kTellInterval;
    Node line = Node::map();
    line.set("stage", name);
    line.set("done", done);
    line.set("total", total);
    (void)write_all(file_, document::to_json(line) + "\n");
  }

 private:
  int file_;
  std::mutex mutex_;
  std::string stage_;
  Clock::time_point next_{};
};

struct Child {
  int pipe = -1;
  std::string text;  // of the line that is being received
  std::optional<Attempt> answer;
  bool reused = false;  // has made other scans
  bool stays = false;   // takes another scan
  bool killed = false, over_time = false;
  std::uint64_t memory = 0;  // cap of its first order: what its idle memory was counted in
  double cpu_seconds = 0;    // of the answer
  double cpu_before = 0;     // of the process, for scans that it made before
  MemorySigns signs = {};    // before it
};

/// A worker that has answered and waits for the next scan.
struct IdleWorker {
  int pid = 0;
  int pipe = -1;
  std::uint64_t memory = 0;
  Clock::time_point since;
  double cpu_seconds = 0;  // of all that it made
};

Node to_document(const Order& order) {
  Node tree = Node::map();
  tree.set("scan", static_cast<std::uint64_t>(order.scan));
  tree.set("threads", order.threads);
  tree.set("memory", order.memory);
  tree.set("part", order.part);
  return tree;
}

/// The next order from the driver; nothing when there are no more.
std::optional<Order> read_order(int pipe) {
  std::string text;
  char c = 0;
  for (;;) {
    const ssize_t n = read(pipe, &c, 1);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return std::nullopt;
    if (c == '\n') break;
    text += c;
  }
  const auto tree = document::parse_json(text, "driver");
  if (!tree) return std::nullopt;
  const Node *scan = tree->find("scan"), *threads = tree->find("threads"), *memory = tree->find("memory");
  const Node* part = tree->find("part");
  if (!scan || !threads || !memory || !part) return std::nullopt;
  return Order{static_cast<std::size_t>(scan->as_integer()), static_cast<int>(threads->as_integer()),
               static_cast<std::uint64_t>(memory->as_integer()), part->as_string()};
}

double seconds_of(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

class LocalExecutor final : public Executor {
 public:
  LocalExecutor(MakeScan make, LocalOptions options) : make_(std::move(make)), options_(std::move(options)) {}
  ~LocalExecutor() override {
    dismiss_idle();
    kill_all();
    while (!running_.empty()) (void)wait(std::chrono::milliseconds(100));
  }

  Result<void> start(const Order& order) override {
    // What the first try changed is not known to processes that were there before it.
    if (order.scan >= tried_.size()) tried_.resize(order.scan + 1);
    const bool first_try = !tried_[order.scan];
    tried_[order.scan] = true;
    if (first_try && hand_on(order)) return {};
    dismiss_idle();  // their memory is part of what this order may use
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      return fail(Code::IoFailed, std::string("no pipe for a worker: ") + std::strerror(errno));
    const pid_t driver = getpid(), pid = fork();
    if (pid < 0) {
      const int reason = errno;
      close(ends[0]);
      close(ends[1]);
      return fail(Code::IoFailed, std::string("no process for a worker: ") + std::strerror(reason));
    }
    if (pid == 0) {
      close(ends[0]);
      be_worker(order, ends[1], driver);
    }
    close(ends[1]);
    take_on(order, {pid, ends[0], order.memory, {}, 0}, false);
    return {};
  }

  std::vector<Ended> wait(std::chrono::milliseconds timeout) override {
    std::vector<pollfd> polled;
    for (const Child& child : children_) polled.push_back({child.pipe, POLLIN, 0});
    if (poll(polled.data(), polled.size(), static_cast<int>(timeout.count())) > 0)
      for (std::size_t i = 0; i < polled.size(); ++i)
        if (polled[i].revents != 0) receive(i);
    std::vector<Ended> ended;
    for (std::size_t i = running_.size(); i-- > 0;) {
      if (children_[i].pipe < 0) {
        ended.push_back(reap(i));
      } else if (children_[i].answer && children_[i].stays) {
        ended.push_back(put_aside(i));
      } else if (Clock::now() - running_[i].began > std::chrono::duration<double>(options_.time_limit_s)) {
        children_[i].over_time = true;
        kill(running_[i].pid, SIGKILL);
      }
    }
    std::reverse(ended.begin(), ended.end());
    if (!idle_.empty() && Clock::now() - idle_.front().since > kIdleAtMost) dismiss_idle();
    return ended;
  }

  const std::vector<Running>& running() const override { return running_; }

  void stop_all() override {
    for (const Running& one : running_) kill(one.pid, SIGTERM);
  }
  void kill_all() override {
    for (std::size_t i = 0; i < running_.size(); ++i) {
      children_[i].killed = true;
      kill(running_[i].pid, SIGKILL);
    }
  }

 private:
  [[noreturn]] void be_worker(Order order, int pipe, pid_t driver) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != driver) _exit(1);
    prctl(PR_SET_NAME, "scanmill-scan");
    for (const Child& other : children_) close(other.pipe);
    if (options_.in_child) options_.in_child();
    signal(SIGINT, SIG_IGN);  // Ctrl-C reaches all processes of a terminal; the driver decides what it means
    signal(SIGHUP, SIG_IGN);  // likewise, when the terminal goes
    signal(SIGUSR1, SIG_IGN);
    for (int made = 1;; ++made) {
      if (order.memory) (void)cap_memory(order.memory);
      PipeProgress progress(pipe);
      const auto began = Clock::now();
      const double cpu = cpu_seconds();
      const Attempt attempt = make_(order, progress);
      const bool small = std::chrono::duration<double>(Clock::now() - began).count() < kSmallScan_s;
      const bool stays = small && made < kScansPerWorker && takes_another(attempt, order);
      Node line = Node::map();
      line.set("attempt", to_document(attempt));
      line.set("stays", stays);
      line.set("cpu_seconds", cpu_seconds() - cpu);
      if (!write_all(pipe, document::to_json(line) + "\n")) _exit(1);
      if (!stays) _exit(0);
      keep_memory();
      const auto next = read_order(pipe);
      if (!next) _exit(0);
      order = *next;
    }
  }

  /// What one small scan gives back, the next takes again: the system need not clear it anew each time.
  static void keep_memory() {
    mallopt(M_MMAP_THRESHOLD, 32 << 20);
    mallopt(M_TRIM_THRESHOLD, kSmallMemory);
  }

  /// Nothing went wrong in this process, and it holds little memory.
  static bool takes_another(const Attempt& attempt, const Order& order) {
    const bool is_sound = attempt.entry.fate == ScanFate::Done || attempt.entry.fate == ScanFate::Unchanged;
    const std::uint64_t most = order.memory > 0 ? std::min(kSmallMemory, order.memory / 2) : kSmallMemory;
    return is_sound && order.threads == 1 && peak_memory() <= most;
  }

  void take_on(const Order& order, const IdleWorker& worker, bool reused) {
    running_.push_back({order, worker.pid, Clock::now(), "start", 0, 0, Clock::now()});
    Child child;
    child.pipe = worker.pipe;
    child.memory = worker.memory;
    child.cpu_before = worker.cpu_seconds;
    child.reused = reused;
    child.signs = memory_signs();
    children_.push_back(std::move(child));
  }

  /// To a worker that waits; false when there is none for this order.
  bool hand_on(const Order& order) {
    while (order.threads == 1 && !idle_.empty()) {
      const IdleWorker idle = idle_.back();
      if (order.memory > idle.memory) return false;
      idle_.pop_back();
      pollfd polled{idle.pipe, POLLIN, 0};
      // One that has something to say has died.
      if (poll(&polled, 1, 0) == 0 && write_all(idle.pipe, document::to_json(to_document(order)) + "\n")) {
        take_on(order, idle, true);
        return true;
      }
      dismiss(idle);
    }
    return false;
  }

  /// It has nothing to lose.
  static void dismiss(const IdleWorker& idle) {
    close(idle.pipe);
    kill(idle.pid, SIGKILL);
    while (waitpid(idle.pid, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  void dismiss_idle() {
    for (const IdleWorker& idle : idle_) dismiss(idle);
    idle_.clear();
  }

  void receive(std::size_t i) {
    Child& child = children_[i];
    char buffer[1 << 16];
    const ssize_t n = read(child.pipe, buffer, sizeof buffer);
    if (n < 0 && (errno == EINTR || errno == EAGAIN)) return;
    if (n <= 0) {
      close(child.pipe);
      child.pipe = -1;
      return;
    }
    running_[i].heard = Clock::now();
    child.text.append(buffer, static_cast<std::size_t>(n));
    for (std::size_t end = child.text.find('\n'); end != std::string::npos; end = child.text.find('\n')) {
      take(child.text.substr(0, end), running_[i], child);
      child.text.erase(0, end + 1);
    }
  }

  static void take(const std::string& text, Running& running, Child& child) {
    const auto line = document::parse_json(text, "worker");
    if (!line) return;
    if (const Node* attempt = line->find("attempt")) {
      if (auto read = attempt_from(*attempt)) child.answer = *std::move(read);
      const Node* stays = line->find("stays");
      child.stays = stays && stays->is_bool() && stays->as_bool();
      const Node* cpu = line->find("cpu_seconds");
      child.cpu_seconds = cpu && cpu->is_number() ? cpu->as_number() : 0;
      return;
    }
    const Node *stage = line->find("stage"), *done = line->find("done"), *total = line->find("total");
    if (!stage || !done || !total) return;
    running.stage = stage->as_string();
    running.done = static_cast<std::uint64_t>(done->as_integer());
    running.total = static_cast<std::uint64_t>(total->as_integer());
  }

  void forget(std::size_t i) {
    running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(i));
    children_.erase(children_.begin() + static_cast<std::ptrdiff_t>(i));
  }

  /// It has answered, and waits for another scan.
  Ended put_aside(std::size_t i) {
    Ended ended;
    ended.order = running_[i].order;
    ended.stage = running_[i].stage;
    ended.reused = children_[i].reused;
    ended.attempt = std::move(children_[i].answer);
    ended.seconds = std::chrono::duration<double>(Clock::now() - running_[i].began).count();
    ended.cpu_seconds = children_[i].cpu_seconds;
    ended.peak_memory = ended.attempt->entry.peak_memory;
    idle_.push_back({running_[i].pid, children_[i].pipe, children_[i].memory, Clock::now(),
                     children_[i].cpu_before + children_[i].cpu_seconds});
    forget(i);
    return ended;
  }

  /// The pipe is closed: the process has ended, or is about to.
  Ended reap(std::size_t i) {
    int status = 0;
    rusage use{};
    while (wait4(running_[i].pid, &status, 0, &use) < 0 && errno == EINTR) {
    }
    Ended ended;
    ended.order = running_[i].order;
    ended.stage = running_[i].stage;
    ended.reused = children_[i].reused;
    ended.attempt = std::move(children_[i].answer);
    ended.over_time = children_[i].over_time;
    ended.seconds = std::chrono::duration<double>(Clock::now() - running_[i].began).count();
    ended.cpu_seconds = std::max(0.0, seconds_of(use.ru_utime) + seconds_of(use.ru_stime) - children_[i].cpu_before);
    ended.peak_memory = static_cast<std::uint64_t>(use.ru_maxrss) * 1024;
    if (WIFSIGNALED(status)) {
      ended.death =
          "signal " + std::to_string(WTERMSIG(status)) + " (" + std::string(strsignal(WTERMSIG(status))) + ")";
      ended.killed_by_system =
          WTERMSIG(status) == SIGKILL && !children_[i].killed && !children_[i].over_time &&
          was_short_of_memory(children_[i].signs, memory_signs(), ended.peak_memory, usable_memory());
    } else if (!ended.attempt) {
      ended.death = "exit code " + std::to_string(WEXITSTATUS(status)) + " without an answer";
    }
    forget(i);
    return ended;
  }

  MakeScan make_;
  LocalOptions options_;
  std::vector<Running> running_;
  std::vector<Child> children_;  // in the same order
  std::vector<IdleWorker> idle_;
  std::vector<bool> tried_;  // by scan
};

}  // namespace

std::unique_ptr<Executor> make_local_executor(MakeScan make, LocalOptions options) {
  return std::make_unique<LocalExecutor>(std::move(make), std::move(options));
}

}  // namespace scanmill::runner
