// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "document/document.hpp"

namespace scanmill::cli {

std::string version();
/// Library -> version this program was built with.
document::Node libraries();
/// What --version shows: version, build, formats, libraries.
std::string version_text();
/// The same as one line of the --json stream.
std::string version_line();

}  // namespace scanmill::cli
