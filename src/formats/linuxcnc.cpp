// SPDX-License-Identifier: Apache-2.0
#include "formats/linuxcnc.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/text.hpp"
#include "formats/cursor.hpp"
#include "formats/text_columns.hpp"

namespace scanmill::formats {
namespace {

constexpr std::uint64_t kMaxIni = 4 << 20;

struct Value {
  std::string text;
  std::uint64_t line = 0;
};
using Section = std::map<std::string, Value>;

std::string upper(std::string text) {
  for (char& c : text)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return text;
}

std::string trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return std::string(text);
}

class Ini {
 public:
  explicit Ini(const ByteSource& source) : source_(source) {}

  Result<CncMachine> run() {
    TRY(read());
    CncMachine machine;
    if (const Value* name = find("EMC", "MACHINE")) machine.name = name->text;
    TRY_ASSIGN(const double unit, linear_unit());
    const std::string letters = coordinates(machine);
    for (std::size_t n = 0; n < letters.size(); ++n) {
      const Section* joint = section("JOINT_" + std::to_string(n));
      const Section* axis = section(std::string("AXIS_") + letters[n]);
      if (joint == nullptr) joint = section("AXIS_" + std::to_string(n));
      if (joint == nullptr) joint = axis;
      if (joint == nullptr) {
        machine.notes.push_back(std::string("coordinate ") + letters[n] + " has no section JOINT_" + std::to_string(n) +
                                " and was passed over");
        continue;
      }
      TRY_ASSIGN(CncJoint read_joint, joint_of(*joint, axis, letters[n], unit, machine));
      machine.joints.push_back(read_joint);
    }
    if (machine.joints.empty())
      return fail(Code::BadInput, "found no section [JOINT_0] or [AXIS_X]; wanted a LinuxCNC INI file", source_.name());
    return machine;
  }

 private:
  Result<void> read() {
    if (source_.size() > kMaxIni)
      return fail(Code::BadInput, "the file is larger than 4 MiB; this is no INI file", source_.name());
    Cursor cursor(source_);
    Section* now = nullptr;
    for (std::uint64_t number = 1; !cursor.at_end(); ++number) {
      TRY_ASSIGN(const std::string_view raw, cursor.line());
      const std::string line = trimmed(raw);
      if (line.empty() || line[0] == '#' || line[0] == ';') continue;
      if (line[0] == '[' && line.find(']') != std::string::npos) {
        now = &sections_[upper(trimmed(line.substr(1, line.find(']') - 1)))];
        continue;
      }
      const std::size_t equals = line.find('=');
      if (now == nullptr || equals == std::string::npos)
        return fail(Code::BadInput, "found " + quoted(line) + ", wanted [SECTION] or KEY = VALUE",
                    line_place(source_.name(), number));
      std::string value = line.substr(equals + 1);
      for (const char* mark : {" #", "\t#", " ;", "\t;"}) value = value.substr(0, value.find(mark));
      now->try_emplace(upper(trimmed(line.substr(0, equals))), Value{trimmed(value), number});
    }
    return {};
  }

  const Section* section(const std::string& name) const {
    const auto at = sections_.find(name);
    return at == sections_.end() ? nullptr : &at->second;
  }
  const Value* find(const std::string& in, const std::string& key) const {
    const Section* found = section(in);
    if (found == nullptr) return nullptr;
    const auto at = found->find(key);
    return at == found->end() ? nullptr : &at->second;
  }

  /// mm per linear unit.
  Result<double> linear_unit() const {
    const Value* value = find("TRAJ", "LINEAR_UNITS");
    if (value == nullptr) return 1.0;
    const std::string word = upper(value->text);
    if (word == "MM" || word == "METRIC" || word == "1" || word == "1.0") return 1.0;
    if (word == "INCH" || word == "IN" || word == "IMPERIAL") return 25.4;
    if (const auto per_mm = parse_number(word); per_mm && *per_mm > 0) return 1 / *per_mm;
    return fail(Code::BadInput, "LINEAR_UNITS: found " + quoted(value->text) + ", wanted mm or inch",
                line_place(source_.name(), value->line));
  }

  /// Letters by joint number.
  std::string coordinates(CncMachine& machine) const {
    std::string text;
    if (const Value* kins = find("KINS", "KINEMATICS")) {
      const std::string words = upper(kins->text);
      if (const auto at = words.find("COORDINATES="); at != std::string::npos)
        text = words.substr(at + 12, words.find(' ', at) - at - 12);
    }
    if (text.empty())
      if (const Value* traj = find("TRAJ", "COORDINATES")) text = upper(traj->text);
    std::string letters;
    for (const char c : text)
      if (std::string_view("XYZABCUVW").find(c) != std::string_view::npos) letters += c;
    if (!letters.empty()) return letters;
    machine.notes.push_back("no COORDINATES are given; joints are taken as X Y Z A B C in order");
    for (std::size_t n = 0; n < 6; ++n)
      if (section("JOINT_" + std::to_string(n)) || section("AXIS_" + std::to_string(n)) ||
          section(std::string("AXIS_") + "XYZABC"[n]))
        letters += "XYZABC"[n];
    return letters;
  }

  Result<std::optional<double>> number(const Section& in, const std::string& key) const {
    const auto at = in.find(key);
    if (at == in.end()) return std::optional<double>();
    const auto value = parse_number(at->second.text);
    if (!value || !std::isfinite(*value))
      return fail(Code::BadInput, key + ": found " + quoted(at->second.text) + ", wanted a number",
                  line_place(source_.name(), at->second.line));
    return std::optional<double>(*value);
  }

  Result<CncJoint> joint_of(const Section& in, const Section* axis, char letter, double unit,
                            CncMachine& machine) const {
    CncJoint joint;
    joint.letter = letter;
    joint.angular = std::string_view("ABC").find(letter) != std::string_view::npos;
    if (const auto type = in.find("TYPE"); type != in.end()) joint.angular = upper(type->second.text) == "ANGULAR";
    const double scale = joint.angular ? 1 : unit;
    const auto get = [&](const char* key, std::optional<double>& out) -> Result<void> {
      TRY_ASSIGN(out, number(in, key));
      if (!out && axis != nullptr) {
        TRY_ASSIGN(out, number(*axis, key));
      }
      if (out) *out *= scale;
      return {};
    };
    TRY(get("MIN_LIMIT", joint.low));
    TRY(get("MAX_LIMIT", joint.high));
    TRY(get("MAX_VELOCITY", joint.velocity));
    TRY(get("MAX_ACCELERATION", joint.acceleration));
    std::optional<double> backlash, home;
    TRY(get("BACKLASH", backlash));
    TRY(get("HOME", home));
    joint.backlash = std::abs(backlash.value_or(0));
    joint.home = home.value_or(0);
    for (const char* key : {"ENCODER_SCALE", "INPUT_SCALE", "STEP_SCALE", "SCALE"}) {
      TRY_ASSIGN(const std::optional<double> counts, number(in, key));
      if (joint.counts_per_unit || !counts || *counts == 0) continue;
      joint.counts_per_unit = std::abs(*counts) / scale;
      if (*counts < 0)
        machine.notes.push_back(std::string("joint ") + letter + " counts downwards (" + key +
                                " is negative); its sign was dropped, turn the axis round where it matters");
    }
    if (joint.low && joint.high && *joint.low > *joint.high)
      return fail(Code::BadInput, "MIN_LIMIT lies above MAX_LIMIT",
                  line_place(source_.name(), in.contains("MIN_LIMIT") ? in.at("MIN_LIMIT").line : 0));
    if (in.contains("COMP_FILE"))
      machine.notes.push_back(std::string("joint ") + letter + " has a COMP_FILE; screw errors are not taken over");
    return joint;
  }

  const ByteSource& source_;
  std::map<std::string, Section> sections_;
};

}  // namespace

Result<CncMachine> read_linuxcnc(const ByteSource& source) { return Ini(source).run(); }

}  // namespace scanmill::formats
