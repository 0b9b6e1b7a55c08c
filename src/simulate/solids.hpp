// SPDX-License-Identifier: Apache-2.0
// The makers of the built-in solids; callers use make_object.
#pragma once
#include <memory>

#include "simulate/object.hpp"

namespace scanmill::simulate {

std::unique_ptr<Object> make_figurine();
std::unique_ptr<Object> make_handset();
std::unique_ptr<Object> make_sphere();
std::unique_ptr<Object> make_torus();
std::unique_ptr<Object> make_cube();

}  // namespace scanmill::simulate
