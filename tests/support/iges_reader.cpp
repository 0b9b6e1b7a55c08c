// SPDX-License-Identifier: Apache-2.0
#include "support/iges_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

namespace scanmill::support {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t a = text.find_first_not_of(' ');
  return a == std::string::npos ? "" : text.substr(a, text.find_last_not_of(' ') - a + 1);
}

long whole(const std::string& text) { return std::atol(text.c_str()); }

/// Parameters between commas up to the semicolon; Hollerith strings by their length.
std::vector<std::string> parameters_of(const std::string& text, std::vector<std::string>& faults) {
  std::vector<std::string> found;
  std::size_t at = 0;
  while (at < text.size()) {
    while (at < text.size() && text[at] == ' ') ++at;
    std::size_t end = at;
    while (end < text.size() && text[end] >= '0' && text[end] <= '9') ++end;
    std::string value;
    if (end > at && end < text.size() && text[end] == 'H') {
      const auto length = static_cast<std::size_t>(whole(text.substr(at, end - at)));
      value = text.substr(end + 1, length);
      at = end + 1 + length;
    } else {
      const std::size_t stop = text.find_first_of(",;", at);
      if (stop == std::string::npos) break;
      value = trimmed(text.substr(at, stop - at));
      at = stop;
    }
    if (at >= text.size()) break;
    found.push_back(value);
    if (text[at] == ';') {
      if (!trimmed(text.substr(at + 1)).empty()) faults.push_back("text behind a record: " + text.substr(at));
      return found;
    }
    if (text[at] != ',') faults.push_back("no delimiter at: " + text.substr(at, 10));
    ++at;
  }
  faults.push_back("a record without end: " + text.substr(0, 40));
  return found;
}

double real(const std::string& text, std::vector<std::string>& faults) {
  std::string plain = text;
  std::replace(plain.begin(), plain.end(), 'D', 'e');
  char* end = nullptr;
  const double value = std::strtod(plain.c_str(), &end);
  if (plain.empty() || *end != 0 || plain.find('.') == std::string::npos) faults.push_back("no real: " + text);
  return value;
}

struct Sections {
  std::map<char, std::vector<std::string>> lines;
};

Sections sections_of(const std::string& bytes, std::vector<std::string>& faults) {
  Sections sections;
  std::string order;
  for (std::size_t at = 0; at < bytes.size(); at += 81) {
    if (at + 81 > bytes.size() || bytes[at + 80] != '\n') {
      faults.push_back("no line of 80 columns at byte " + std::to_string(at));
      return sections;
    }
    const std::string line = bytes.substr(at, 80);
    const char letter = line[72];
    auto& here = sections.lines[letter];
    here.push_back(line);
    if (order.empty() || order.back() != letter) order += letter;
    if (whole(trimmed(line.substr(73))) != static_cast<long>(here.size())) faults.push_back("sequence: " + line);
  }
  if (order != "SGDPT") faults.push_back("sections " + order);
  return sections;
}

void read_directory(const std::vector<std::string>& lines, IgesFile& file, std::vector<std::array<long, 3>>& records) {
  long next = 1;
  for (std::size_t i = 0; i + 1 < lines.size(); i += 2) {
    auto field = [&](std::size_t line, std::size_t n) { return lines[i + line].substr(8 * n, 8); };
    IgesEntity entity;
    entity.type = static_cast<int>(whole(field(0, 0)));
    entity.form = static_cast<int>(whole(field(1, 4)));
    entity.level = whole(field(0, 4));
    entity.colour = whole(field(1, 2));
    entity.status = field(0, 8);
    entity.label = trimmed(field(1, 7));
    entity.subscript = whole(field(1, 8));
    if (field(0, 0) != field(1, 0)) file.faults.push_back("two types in one entry: " + lines[i]);
    const long first = whole(field(0, 1)), count = whole(field(1, 3));
    if (first != next || count < 1) file.faults.push_back("parameter pointer " + std::to_string(first));
    next = first + count;
    const auto number = static_cast<long>(i + 1);
    records.push_back({number, first, count});
    file.entities[number] = entity;
  }
  if (next != file.parameter_lines + 1) file.faults.push_back("records end at line " + std::to_string(next - 1));
}

/// Faces out of entities.
class Shape {
 public:
  Shape(const IgesFile& file, IgesShape& out) : file_(file), out_(out) {}

  void face_of_510(long number) {
    const IgesEntity& face = entity(number, 510);
    if (face.parameters.size() < 4) return fault("510 too short");
    const IgesEntity& loop = entity(pointer(face, 3), 508);
    std::array<Vec3, 3> corners{};
    if (loop.parameters.size() != 16 || loop.parameters[0] != "3") return fault("508 is no triangle");
    for (std::size_t e = 0; e < 3; ++e) {
      const IgesEntity& list = entity(pointer(loop, 2 + 5 * e), 504);
      const auto row = static_cast<std::size_t>(whole(loop.parameters[3 + 5 * e]));
      const bool along = loop.parameters[4 + 5 * e] == "1";
      if (row < 1 || 1 + 5 * row > list.parameters.size()) return fault("508 names no edge");
      const std::size_t at = 1 + 5 * (row - 1);
      ++used_[{row, along}];
      const Vec3 a = vertex(list, at + 1), b = vertex(list, at + 3);
      const IgesEntity& line = entity(pointer(list, at), 110);
      if (!(point(line, 0) == a) || !(point(line, 3) == b)) fault("an edge's line does not end at its vertices");
      corners[e] = along ? a : b;
      ends_[e] = along ? b : a;
    }
    for (std::size_t e = 0; e < 3; ++e)
      if (!(ends_[e] == corners[(e + 1) % 3])) fault("a loop is not closed");
    const IgesEntity& plane = entity(pointer(face, 0), 190);
    const Vec3 place = point(entity(pointer(plane, 0), 116), 0), normal = point(entity(pointer(plane, 1), 123), 0);
    for (const Vec3& corner : corners)
      out_.greatest_plane_gap = std::max(out_.greatest_plane_gap, std::abs(dot(corner - place, normal)));
    if (std::abs(norm(normal) - 1) > 1e-12) fault("a normal is no unit vector");
    if (dot(cross(corners[1] - corners[0], corners[2] - corners[0]), normal) <= 0) fault("a normal points inward");
    add(corners, face, 4);
  }

  void face_of_144(const IgesEntity& face) {
    const IgesEntity& surface = entity(pointer(face, 0), 128);
    const IgesEntity& border = entity(pointer(face, 3), 142);
    if (pointer(border, 1) != pointer(face, 0)) fault("142 lies on another surface");
    const IgesEntity& curve = entity(pointer(border, 3), 102);
    std::array<Vec3, 3> corners{};
    if (curve.parameters.size() != 4) return fault("102 is no triangle");
    std::array<Vec3, 3> ends{};
    for (std::size_t e = 0; e < 3; ++e) {
      const IgesEntity& line = entity(pointer(curve, 1 + e), 110);
      corners[e] = point(line, 0);
      ends[e] = point(line, 3);
    }
    for (std::size_t e = 0; e < 3; ++e)
      if (!(ends[e] == corners[(e + 1) % 3])) fault("a 102 is not closed");
    const auto poles = poles_of(surface);
    if (!(poles[0] == corners[0]) || !(poles[1] == corners[1]) || !(poles[2] == corners[2]) ||
        norm(poles[3] - (corners[1] + corners[2] - corners[0])) > 1e-9)
      fault("a 128 is not the plane of its triangle");
    add(corners, face, 4);
  }

  void face_of_128(const IgesEntity& face) {
    const auto poles = poles_of(face);
    if (!(poles[2] == poles[3])) fault("a 128 is no triangle");
    add({poles[0], poles[1], poles[2]}, face, face.parameters.size());
  }

  void shell(const IgesEntity& shell) {
    const auto count = static_cast<std::size_t>(whole(shell.parameters[0]));
    if (shell.parameters.size() != 1 + 2 * count) return fault("514 has another length");
    used_.clear();
    for (std::size_t f = 0; f < count; ++f) face_of_510(pointer(shell, 1 + 2 * f));
    for (const auto& [edge, times] : used_) {
      if (times != 1) fault("an edge is used twice in one direction");
      if (shell.form == 1 && used_.count({edge.first, !edge.second}) == 0) fault("a closed shell has an open edge");
    }
  }

  const IgesEntity& entity(long number, int type) {
    static const IgesEntity kNone;
    const auto at = file_.entities.find(number);
    if (at != file_.entities.end() && at->second.type == type) return at->second;
    fault("pointer " + std::to_string(number) + " is no " + std::to_string(type));
    return kNone;
  }
  static long pointer(const IgesEntity& entity, std::size_t at) {
    return at < entity.parameters.size() ? whole(entity.parameters[at]) : 0;
  }
  Vec3 point(const IgesEntity& entity, std::size_t at) {
    if (at + 3 > entity.parameters.size()) {
      fault("no point in " + std::to_string(entity.type));
      return {};
    }
    auto value = [&](std::size_t i) { return real(entity.parameters[at + i], out_.faults); };
    return {value(0), value(1), value(2)};
  }

 private:
  void fault(const std::string& text) { out_.faults.push_back(text); }
  Vec3 vertex(const IgesEntity& list, std::size_t at) {
    const IgesEntity& vertices = entity(pointer(list, at), 502);
    return point(vertices, 1 + 3 * static_cast<std::size_t>(whole(list.parameters[at + 1]) - 1));
  }
  std::array<Vec3, 4> poles_of(const IgesEntity& surface) {
    std::array<Vec3, 4> poles{};
    if (surface.parameters.size() < 37) {
      fault("128 too short");
      return poles;
    }
    for (std::size_t p = 0; p < 4; ++p) poles[p] = point(surface, 9 + 8 + 4 + 3 * p);
    return poles;
  }
  void add(const std::array<Vec3, 3>& corners, const IgesEntity& face, std::size_t properties) {
    out_.faces.push_back(corners);
    out_.face_levels.push_back(face.level);
    out_.face_colours.push_back(-face.colour);
    if (face.colour >= 0)
      fault("a face without colour");
    else
      (void)entity(-face.colour, 314);
    out_.area += norm(cross(corners[1] - corners[0], corners[2] - corners[0])) / 2;
    out_.volume += dot(corners[0], cross(corners[1], corners[2])) / 6;
    if (properties >= face.parameters.size()) return;
    if (face.parameters.size() != properties + 3 || face.parameters[properties] != "0" ||
        face.parameters[properties + 1] != "1")
      return fault("a face's properties");
    const IgesEntity& name = entity(pointer(face, properties + 2), 406);
    out_.face_names.push_back(name.parameters.size() == 2 ? name.parameters[1] : "");
  }

  const IgesFile& file_;
  IgesShape& out_;
  std::array<Vec3, 3> ends_{};
  std::map<std::pair<std::size_t, bool>, int> used_;
};

}  // namespace

std::size_t IgesFile::count(int type, int form) const {
  std::size_t found = 0;
  for (const auto& [number, entity] : entities) found += entity.type == type && (form < 0 || entity.form == form);
  return found;
}

IgesFile read_iges(const std::string& bytes) {
  IgesFile file;
  Sections sections = sections_of(bytes, file.faults);
  if (!file.faults.empty()) return file;
  for (const std::string& line : sections.lines['S']) file.start.push_back(trimmed(line.substr(0, 72)));
  std::string global;
  for (const std::string& line : sections.lines['G']) global += line.substr(0, 72);
  file.global = parameters_of(global, file.faults);
  const auto& parameters = sections.lines['P'];
  file.parameter_lines = static_cast<long>(parameters.size());
  file.directory_lines = static_cast<long>(sections.lines['D'].size());
  std::vector<std::array<long, 3>> records;
  read_directory(sections.lines['D'], file, records);
  for (const auto& [number, first, count] : records) {
    std::string text;
    for (long i = first - 1; i < first - 1 + count && i < file.parameter_lines; ++i) {
      const std::string& line = parameters[static_cast<std::size_t>(i)];
      if (line[64] != ' ' || whole(trimmed(line.substr(65, 7))) != number)
        file.faults.push_back("back pointer: " + line);
      text += line.substr(0, 64);
    }
    IgesEntity& entity = file.entities[number];
    entity.parameters = parameters_of(text, file.faults);
    if (entity.parameters.empty() || whole(entity.parameters[0]) != entity.type)
      file.faults.push_back("record of another type: " + text.substr(0, 40));
    else
      entity.parameters.erase(entity.parameters.begin());
  }
  const std::string ends = sections.lines['T'][0];
  const char letters[] = {'S', 'G', 'D', 'P'};
  for (std::size_t s = 0; s < 4; ++s)
    if (ends[8 * s] != letters[s] ||
        whole(ends.substr(8 * s + 1, 7)) != static_cast<long>(sections.lines[letters[s]].size()))
      file.faults.push_back("terminate: " + ends);
  return file;
}

IgesShape shape_of(const IgesFile& file) {
  IgesShape out;
  Shape shape(file, out);
  for (const auto& [number, entity] : file.entities) {
    if (entity.type == 186) {
      ++out.solids;
      (void)shape.entity(Shape::pointer(entity, 0), 514);
    }
    if (entity.type == 514) {
      if (entity.status == "00000000") (entity.form == 1 ? out.closed_shells : out.open_shells) += 1;
      shape.shell(entity);
    }
    if (entity.type == 144) shape.face_of_144(entity);
    if (entity.type == 128 && entity.status.substr(2, 2) == "02") shape.face_of_128(entity);
    if (entity.type == 110 && entity.status.substr(2, 2) == "02")
      out.line_length += norm(shape.point(entity, 3) - shape.point(entity, 0));
  }
  return out;
}

}  // namespace scanmill::support
