// SPDX-License-Identifier: Apache-2.0
// The page's style sheet.
#pragma once

namespace scanmill::report {

/// Dark on light; screens from 360 pixels and paper. Blue and vermilion tell passed from failed, always with a word.
extern const char kStyleSheet[];

}  // namespace scanmill::report
