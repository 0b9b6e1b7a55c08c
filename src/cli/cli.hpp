// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace scanmill::cli {

/// Parses the command line, runs the command, returns the exit code. No exception leaves it.
int run(int argc, char** argv);

}  // namespace scanmill::cli
