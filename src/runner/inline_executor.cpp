// SPDX-License-Identifier: Apache-2.0
#include "runner/executor.hpp"
#include "runner/machine.hpp"

namespace scanmill::runner {
namespace {

class InlineExecutor final : public Executor {
 public:
  InlineExecutor(MakeScan make, Progress& progress) : make_(std::move(make)), progress_(progress) {}

  Result<void> start(const Order& order) override {
    const auto began = std::chrono::steady_clock::now();
    const double cpu = cpu_seconds();
    Ended ended;
    ended.order = order;
    ended.attempt = make_(order, progress_);
    ended.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    ended.cpu_seconds = cpu_seconds() - cpu;  // that of the entry counts all attempts so far
    ended.peak_memory = ended.attempt->entry.peak_memory;
    ended_.push_back(std::move(ended));
    return {};
  }
  std::vector<Ended> wait(std::chrono::milliseconds) override { return std::exchange(ended_, {}); }
  const std::vector<Running>& running() const override { return none_; }
  void stop_all() override {}
  void kill_all() override {}

 private:
  MakeScan make_;
  Progress& progress_;
  std::vector<Ended> ended_;
  std::vector<Running> none_;
};

}  // namespace

std::unique_ptr<Executor> make_inline_executor(MakeScan make, Progress& progress) {
  return std::make_unique<InlineExecutor>(std::move(make), progress);
}

}  // namespace scanmill::runner
