// SPDX-License-Identifier: Apache-2.0
// How fast the machine is at this moment: a fixed piece of work, timed.
#pragma once

namespace scanmill::timing {

/// CPU seconds of the calling thread for about 0.05 s of arithmetic on numbers in the second cache, the same work every
/// time and in every version. Measured around the repeats of a bench it tells a busy or throttled machine from a slower
/// program.
double yardstick_cpu_seconds();

}  // namespace scanmill::timing
