// SPDX-License-Identifier: Apache-2.0
#include "refine/params.hpp"

namespace scanmill::refine {

std::span<const Field> Params::fields() {
  using P = Params;
  static const Field table[] = {
      field<P, &P::poses>("poses", "", "Move views within the machine's stated accuracy to where they fit each other."),
      field<P, &P::max_shift_mm>(
          "max_shift_mm", "",
          "How far the sensor may have stood from where the machine says; off: what the plan's joints state.",
          {0, 1000}),
      field<P, &P::max_turn_deg>("max_turn_deg", "",
                                 "How much it may have been turned from there; off: what the plan's joints state.",
                                 {0, 10}),
      field<P, &P::patch_mm>("patch_mm", "",
                             "Edge of the pieces of surface that views are compared by; off: some 60 points each.",
                             {0, 1000, true}),
      field<P, &P::datum>("datum", "",
                          "Bodies that the plan keeps out of and that move with the part stand exactly where it says: "
                          "they hold the whole in place."),
      field<P, &P::rounds>("rounds", "", "Most rounds of matching and moving.", {1, 1000}),
  };
  return table;
}

}  // namespace scanmill::refine
