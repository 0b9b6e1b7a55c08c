// SPDX-License-Identifier: Apache-2.0
// Faults on purpose, for the tests of the runner: a worker that dies, hangs or hogs at a scan of a given name.
#pragma once
#include <string>

namespace scanmill::runner {

/// SCANMILL_TEST_FAULT="crash:NAME,hang:NAME,hog:NAME" names scans; "slow:20" makes every scan cost 20 ms of CPU more.
/// Without it nothing happens.
void act_on_test_fault(const std::string& scan);

}  // namespace scanmill::runner
