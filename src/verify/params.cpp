// SPDX-License-Identifier: Apache-2.0
#include "verify/params.hpp"

namespace scanmill::verify {

std::span<const Field> Params::fields() {
  using P = Params;
  static const Field kTable[] = {
      field<P, &P::max_error_mm>("max_error_mm", "",
                                 "Gate: greatest distance of any input point from the mesh, mm; a mesh beyond it is "
                                 "rejected (exit code 4).",
                                 {0, 1e6, true}),
      field<P, &P::rms_mm>(
          "rms_mm", "",
          "Gate: root of the mean squared distance of all input points from the mesh, mm; a mesh beyond "
          "it is rejected (exit code 4).",
          {0, 1e6, true}),
  };
  return kTable;
}

}  // namespace scanmill::verify
