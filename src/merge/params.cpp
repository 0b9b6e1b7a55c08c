// SPDX-License-Identifier: Apache-2.0
#include "merge/params.hpp"

namespace scanmill::merge {

std::span<const Field> Params::fields() {
  using P = Params;
  static const Field kTable[] = {
      field<P, &P::min_patch_triangles>("min_patch_triangles", "",
                                        "Smaller pieces join the neighbouring patch with the flattest shared border.",
                                        {1, 1e9}),
      field<P, &P::min_component_share>("min_component_share", "",
                                        "Components with a smaller share of all faces are dropped and listed.", {0, 1}),
  };
  return kTable;
}

}  // namespace scanmill::merge
