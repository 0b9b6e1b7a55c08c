// SPDX-License-Identifier: Apache-2.0
#include "grow/params.hpp"

namespace scanmill::grow {

std::span<const Field> SeedParams::fields() {
  using P = SeedParams;
  static const Field kTable[] = {
      field<P, &P::spacing_bins>("spacing_bins", "", "Least distance between automatic seeds, in bin edges.", {1, 1e9}),
      field<P, &P::cover>("cover", "",
                          "true: components that no seed reaches become patches of their own; false: only what the "
                          "seeds reach is kept (option: --cover=false)."),
  };
  return kTable;
}

}  // namespace scanmill::grow
