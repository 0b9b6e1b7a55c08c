// SPDX-License-Identifier: Apache-2.0
// What `reduce` writes and `mesh --as-is` reads: a PLY whose vertices are the kept points, followed by an element `bin`
// with every occupied bin, its point and its frame.
#pragma once
#include "base/bytes.hpp"
#include "reduce/reduce.hpp"

namespace scanmill::pipeline {

/// Does not commit the sink.
Result<void> write_reduced(const reduce::ReducedCloud& cloud, ByteSink& sink);
/// The same cloud again, to the last bit.
/// errors  BadInput when the file was not written by write_reduced, or holds numbers that it does not write
Result<reduce::ReducedCloud> read_reduced(const ByteSource& source);

}  // namespace scanmill::pipeline
