// SPDX-License-Identifier: Apache-2.0
#include "store/reason.hpp"

#include <cerrno>
#include <system_error>

namespace scanmill::store {

Error system_failure(int error_number, const std::string& doing, const std::string& path) {
  const bool full = error_number == ENOSPC || error_number == EDQUOT;
  std::string message = "cannot " + doing + ": " + std::system_category().message(error_number);
  if (full) message += "; free space there or choose another place";
  return fail(full ? Code::NoSpace : Code::IoFailed, std::move(message), path);
}

}  // namespace scanmill::store
