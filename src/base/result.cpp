// SPDX-License-Identifier: Apache-2.0
#include "base/result.hpp"

namespace scanmill {

const char* name_of(Code code) {
  switch (code) {
    case Code::BadUsage:
      return "BadUsage";
    case Code::BadParameter:
      return "BadParameter";
    case Code::BadInput:
      return "BadInput";
    case Code::IoFailed:
      return "IoFailed";
    case Code::NoSpace:
      return "NoSpace";
    case Code::Cancelled:
      return "Cancelled";
    case Code::Unsupported:
      return "Unsupported";
    case Code::Internal:
      return "Internal";
  }
  return "Internal";
}

std::string Error::text() const { return where.empty() ? message : where + ": " + message; }

Error Error::at(const std::string& place) && {
  where = where.empty() ? place : place + ": " + where;
  return std::move(*this);
}

}  // namespace scanmill
