// SPDX-License-Identifier: Apache-2.0
// What a pass over a piece of the points has seen, to bytes and back. Internal to `verify`.
#pragma once
#include "verify/seen.hpp"
#include "verify/verify.hpp"

namespace scanmill::verify {

PieceVerdict verdict_of(const Seen& seen, const Marks& marks);
/// Adds what it holds; false when it is cut or of another mesh (what was added by then stays).
bool add_verdict(const PieceVerdict& verdict, Seen& seen, Marks& marks);

}  // namespace scanmill::verify
