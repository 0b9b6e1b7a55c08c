// SPDX-License-Identifier: Apache-2.0
#include "optimise/params.hpp"

namespace scanmill::optimise {

std::span<const Field> Params::fields() {
  using P = Params;
  static const Field kTable[] = {
      field<P, &P::smooth>("smooth", "", "Swap edges until the smallest interior angles cannot grow."),
      field<P, &P::feature>("feature", "",
                            "Then swap edges until the normals of neighbouring triangles vary least, which brings out "
                            "edges of the part."),
  };
  return kTable;
}

}  // namespace scanmill::optimise
