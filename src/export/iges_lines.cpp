// SPDX-License-Identifier: Apache-2.0
#include "export/iges_lines.hpp"

#include <algorithm>
#include <string>

namespace scanmill::exporting {
namespace {

constexpr std::string_view kBlanks = "                                                                        ";

/// `value` at the right end of `width` columns.
template <class Number>
void put_right(TextBuffer& out, Number value, std::size_t width, char fill = ' ') {
  std::array<char, 24> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  const auto size = static_cast<std::size_t>(end - digits.data());
  for (std::size_t i = size; i < width; ++i) out.text({&fill, 1});
  out.text({digits.data(), size});
}

void put_left(TextBuffer& out, std::string_view text, std::size_t width) {
  text = text.substr(0, width);
  out.text(text).text(kBlanks.substr(0, width - text.size()));
}

void put_sequence(TextBuffer& out, char letter, std::uint64_t number) {
  out.text({&letter, 1});
  put_right(out, number, 7);
  out.text("\n");
}

IgesReal real_from(std::string_view plain) {
  IgesReal real;
  auto add = [&](std::string_view text) {
    std::copy(text.begin(), text.end(), real.text.begin() + real.size);
    real.size = static_cast<std::uint8_t>(real.size + text.size());
  };
  const std::size_t e = plain.find('e');
  add(plain.substr(0, e));
  if (plain.substr(0, e).find('.') == std::string_view::npos) add(".");
  if (e == std::string_view::npos) return real;
  add("D");
  add(plain.substr(e + 1));
  return real;
}

}  // namespace

IgesReal iges_real(double value) {
  if (value == 0) value = 0;  // no -0
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return real_from({text.data(), static_cast<std::size_t>(end - text.data())});
}

IgesReal iges_fixed(double value, int decimals) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed, decimals).ptr;
  std::string_view shown(text.data(), static_cast<std::size_t>(end - text.data()));
  while (shown.back() == '0') shown.remove_suffix(1);
  return real_from(shown == "-0." ? "0." : shown);
}

std::string iges_hollerith(std::string_view text) { return std::to_string(text.size()) + "H" + std::string(text); }

void IgesDirectory::write(const IgesEntry& entry) {
  const std::uint64_t number = iges_directory_number(entity_);
  put_right(out_, entry.type, 8);
  put_right(out_, first_line_, 8);
  for (int zero = 0; zero < 2; ++zero) put_right(out_, 0, 8);  // structure, line font
  put_right(out_, entry.level, 8);
  for (int zero = 0; zero < 3; ++zero) put_right(out_, 0, 8);  // view, transformation, label display
  out_.text(entry.status);
  put_sequence(out_, 'D', number);
  put_right(out_, entry.type, 8);
  put_right(out_, 0, 8);  // line weight: the receiver's
  put_right(out_, entry.colour, 8);
  put_right(out_, lines_[entity_], 8);
  put_right(out_, entry.form, 8);
  out_.text(kBlanks.substr(0, 16));
  put_left(out_, entry.label, 8);
  put_right(out_, entry.subscript, 8);
  put_sequence(out_, 'D', number + 1);
  first_line_ += lines_[entity_];
  ++entity_;
}

void IgesParameters::line_end(std::size_t used) {
  out_.text(kBlanks.substr(0, kIgesColumns + 1 - used));
  put_right(out_, iges_directory_number(entity_), 7);
  put_sequence(out_, 'P', ++line_);
}

void IgesHeader::free_text(std::string_view text) {
  put_left(out_, text, 72);
  put_sequence(out_, letter_, ++line_);
}

void IgesHeader::hollerith(std::string_view shown) { text(iges_hollerith(shown)); }

void IgesHeader::line_end(std::size_t used) {
  out_.text(kBlanks.substr(0, 72 - used));
  put_sequence(out_, letter_, ++line_);
}

void put_iges_global(IgesHeader& global, std::string_view what, double resolution_mm, double largest_mm) {
  // A date is wanted; a fixed one keeps equal meshes equal files.
  constexpr std::string_view kDate = "20000101.000000";
  const std::string product = "scanmill " + std::string(what), file = std::string(what) + ".igs";
  global.record([&](IgesHeader& record) {
    record.text("1H,");
    record.text("1H;");
    for (const std::string_view name : {std::string_view(product), std::string_view(file), std::string_view("scanmill"),
                                        std::string_view("scanmill")})
      record.hollerith(name);
    for (const int digits : {32, 38, 7, 308, 15}) record.integer(digits);
    record.hollerith(product);
    record.text("1.");  // scale
    record.integer(2);  // millimetres
    record.hollerith("MM");
    record.integer(1);  // line weights
    record.text("0.01");
    record.hollerith(kDate);
    record.real(iges_real(resolution_mm));
    record.real(iges_real(largest_mm));
    record.hollerith("scanmill");
    record.text("");
    record.integer(11);  // IGES 5.3
    record.integer(0);   // no drafting standard
    record.hollerith(kDate);
  });
}

void put_iges_terminate(TextBuffer& out, std::uint64_t start, std::uint64_t global, std::uint64_t directory,
                        std::uint64_t parameters) {
  const std::pair<char, std::uint64_t> sections[] = {{'S', start}, {'G', global}, {'D', directory}, {'P', parameters}};
  for (const auto& [letter, lines] : sections) {
    out.text({&letter, 1});
    put_right(out, lines, 7);
  }
  out.text(kBlanks.substr(0, 40));
  put_sequence(out, 'T', 1);
}

}  // namespace scanmill::exporting
