// SPDX-License-Identifier: Apache-2.0
// A line of a text file as cells, and what the cells of a header line name.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace scanmill::formats {

/// What stands between the cells of a line: ',', ';' or '\t' alone, or any run of blanks with at most one of the three.
constexpr char kAnySeparator = '\0';

/// Words of a line between blanks, tabs, commas and semicolons, quotes removed; two commas in a row hold an empty word.
std::vector<std::string_view> columns_of(std::string_view line);
/// Cells between separators of one kind, blanks and quotes around them removed; empty cells count. kAnySeparator: as
/// columns_of.
std::vector<std::string_view> cells_of(std::string_view line, char separator);

/// The separator of a line of numbers: the first of ; , tab that leaves three cells with a number each. Tabs in a row
/// align columns, they hold no empty cells; then, and when there is none of the three: kAnySeparator.
char separator_of_numbers(std::string_view line);

/// Without blanks at both ends and a carriage return at the last.
std::string_view trimmed(std::string_view text);
/// A cell that is one number and nothing else.
bool is_number(std::string_view cell);
/// `1,5` or `1.234,5`: one comma with digits on both sides, points before it only as marks of thousands.
bool is_decimal_comma(std::string_view cell);
/// "1,5;2,5;3,5", "1.234,5;2;3" and "1,5 2,5 3,5": read as points these would be silently wrong.
bool has_decimal_commas(std::string_view line);

/// How often each of x, y, z is the name of a cell, and where last; the unit stated there in mm, 0 for none.
struct AxisNames {
  std::array<double, 3> mm{};
  std::array<std::uint32_t, 3> place{};
  std::array<int, 3> count{};
  bool all() const { return count[0] == 1 && count[1] == 1 && count[2] == 1; }
  bool two() const { return (count[0] > 0) + (count[1] > 0) + (count[2] > 0) >= 2; }
  bool side_by_side() const { return all() && place[1] == place[0] + 1 && place[2] == place[1] + 1; }
};
/// A cell names an axis when it is its letter, alone or with a unit behind it: `X`, `y [mm]`, `Z(m)`, `x_mm`, `Y/mm`.
AxisNames axis_names(const std::vector<std::string_view>& cells);

/// The cells of a header line over lines of numbers with this separator: split like them where the line holds that
/// separator, else by its own. Units in brackets of their own (`X [mm] Y [mm]`) belong to the name before them.
std::vector<std::string_view> header_cells(std::string_view line, char separator_of_data);

}  // namespace scanmill::formats
