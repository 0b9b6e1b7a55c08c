// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "document/document.hpp"

namespace scanmill::cli {

std::string version();
/// Library -> version this program was built with.
document::Node libraries();
/// What --version shows: version, build, features, libraries.
std::string version_text();

}  // namespace scanmill::cli
