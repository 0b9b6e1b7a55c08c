// SPDX-License-Identifier: Apache-2.0
// What turns the 3-D view, inline as everything on the page. Internal to `report`.
#pragma once

namespace scanmill::report {

/// The text between the script tags. Reads what add_view writes; without WebGL it says so and leaves the picture.
extern const char kViewScript[];

}  // namespace scanmill::report
