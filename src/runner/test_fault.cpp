// SPDX-License-Identifier: Apache-2.0
#include "runner/test_fault.hpp"

#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>

#include "runner/machine.hpp"

namespace scanmill::runner {

void act_on_test_fault(const std::string& scan) {
  const char* asked = std::getenv("SCANMILL_TEST_FAULT");
  if (!asked) return;
  const std::string faults = "," + std::string(asked) + ",";
  const auto named = [&](const char* fault) {
    return faults.find("," + std::string(fault) + ":" + scan + ",") != std::string::npos;
  };
  if (named("crash")) raise(SIGSEGV);
  if (named("kill")) raise(SIGKILL);
  while (named("hang")) pause();
  // "slow:20" makes every scan cost that many ms of CPU more, as a build that became slower would.
  if (const auto at = faults.find(",slow:"); at != std::string::npos) {
    const double until = cpu_seconds() + 1e-3 * std::atof(faults.c_str() + at + 6);
    while (cpu_seconds() < until) {
    }
  }
  if (named("hog")) {
    std::vector<std::unique_ptr<char[]>> all;  // small pieces: large ones would be paged
    for (;;) {
      all.push_back(std::make_unique<char[]>(512));
      std::memset(all.back().get(), 1, 512);
    }
  }
}

}  // namespace scanmill::runner
