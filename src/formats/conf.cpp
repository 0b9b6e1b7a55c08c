// SPDX-License-Identifier: Apache-2.0
#include "formats/conf.hpp"

#include <array>

#include "base/text.hpp"
#include "formats/cursor.hpp"
#include "formats/text_columns.hpp"

namespace scanmill::formats {
namespace {

constexpr std::uint64_t kMaxConf = 16 << 20;

Result<ConfView> read_view(const std::vector<std::string_view>& words, std::string_view line,
                           const std::string& place) {
  std::array<double, 7> numbers{};
  bool good = words.size() == 9;
  for (std::size_t i = 0; good && i < 7; ++i) {
    const auto value = parse_number(words[i + 2]);
    good = value.has_value();
    numbers[i] = value.value_or(0);
  }
  if (!good)
    return fail(Code::BadInput, "found " + quoted(line) + ", wanted \"bmesh FILE tx ty tz qx qy qz qw\"", place);
  ConfView view;
  view.file = words[1];
  while (view.file.starts_with("./")) view.file.erase(0, 2);
  if (!is_inside(view.file))
    return fail(Code::BadInput,
                "found the file name " + quoted(words[1]) + ", wanted one inside the folder of the .conf", place);
  auto pose =
      pose_from_quaternion(-numbers[3], -numbers[4], -numbers[5], numbers[6], {numbers[0], numbers[1], numbers[2]});
  if (!pose.ok()) return std::move(pose.error()).at(place);
  view.pose = *pose;
  return view;
}

}  // namespace

Result<std::vector<ConfView>> read_conf(const ByteSource& source) {
  if (source.size() > kMaxConf)
    return fail(Code::BadInput, "the file is larger than 16 MiB; this is no list of views", source.name());
  std::vector<ConfView> views;
  Cursor cursor(source);
  for (std::uint64_t number = 1; !cursor.at_end(); ++number) {
    TRY_ASSIGN(const std::string_view line, cursor.line());
    const auto words = words_of(line);
    if (is_comment_or_blank(line) || words[0] == "camera") continue;
    const std::string place = line_place(source.name(), number);
    if (words[0] != "bmesh" && words[0] != "mesh")
      return fail(Code::BadInput, "found " + quoted(words[0]) + ", wanted bmesh, mesh or camera", place);
    TRY_ASSIGN(ConfView view, read_view(words, line, place));
    for (const ConfView& other : views)
      if (other.file == view.file)
        return fail(Code::BadInput, "the file " + quoted(view.file) + " is named a second time", place);
    views.push_back(std::move(view));
  }
  if (views.empty()) return fail(Code::BadInput, "found no bmesh line, wanted one per view", source.name());
  return views;
}

Result<bool> is_conf(const ByteSource& source) {
  if (source.size() > kMaxConf) return false;
  Cursor cursor(source);
  while (!cursor.at_end()) {
    const auto line = cursor.line();
    if (!line.ok()) return line.error().code == Code::BadInput ? Result<bool>(false) : Result<bool>(line.error());
    const auto words = words_of(*line);
    if (!words.empty() && (words[0] == "bmesh" || words[0] == "mesh")) return true;
  }
  return false;
}

}  // namespace scanmill::formats
