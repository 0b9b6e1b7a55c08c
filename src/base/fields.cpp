// SPDX-License-Identifier: Apache-2.0
#include "base/fields.hpp"

#include <cmath>

#include "base/text.hpp"

namespace scanmill {

std::vector<std::string> problems_of(std::span<const Field> table, const void* object) {
  std::vector<std::string> problems;
  void* target = const_cast<void*>(object);
  for (const Field& row : table) {
    double value = 0;
    bool present = true;
    std::visit(
        [&](auto access) {
          auto& member = *access(target);
          using M = std::remove_cvref_t<decltype(member)>;
          if constexpr (std::is_same_v<M, std::optional<double>>) {
            present = member.has_value();
            if (present) value = *member;
          } else {
            value = static_cast<double>(member);
          }
        },
        row.member);
    if (!present) continue;
    const bool low = row.minimum_excluded ? value <= row.minimum : value < row.minimum;
    if (!(low || value > row.maximum || std::isnan(value))) continue;
    problems.push_back(std::string(row.name) + ": found " + number_text(value) + "; allowed " +
                       (row.minimum_excluded ? "(" : "[") + number_text(row.minimum) + ", " + number_text(row.maximum) +
                       "]");
  }
  return problems;
}

}  // namespace scanmill
