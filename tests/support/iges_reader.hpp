// SPDX-License-Identifier: Apache-2.0
// An IGES reader that shares nothing with src/: fixed columns, directory, pointers, and the surfaces as triangles.
#pragma once
#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "geom/vec3.hpp"

namespace scanmill::support {

struct IgesEntity {
  int type = 0, form = 0;
  long level = 0, colour = 0, subscript = 0;
  std::string status, label;
  std::vector<std::string> parameters;  // the type left out
};

struct IgesFile {
  std::vector<std::string> faults;  // whatever breaks the format; empty on a sound file
  std::vector<std::string> start;
  std::vector<std::string> global;
  std::map<long, IgesEntity> entities;  // by directory number
  long directory_lines = 0, parameter_lines = 0;

  std::size_t count(int type, int form = -1) const;
};

IgesFile read_iges(const std::string& bytes);

/// The faces of a file by its entities: corners of each 510, 144 or degenerate 128, and the lines of no face.
struct IgesShape {
  std::vector<std::string> faults;
  std::vector<std::array<Vec3, 3>> faces;
  std::vector<long> face_colours, face_levels;  // directory numbers, levels
  std::vector<std::string> face_names;
  double area = 0, volume = 0, line_length = 0;
  std::size_t solids = 0, open_shells = 0, closed_shells = 0;
  double greatest_plane_gap = 0;  // corner to its face's plane (190)
};
IgesShape shape_of(const IgesFile& file);

}  // namespace scanmill::support
