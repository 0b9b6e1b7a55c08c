// SPDX-License-Identifier: Apache-2.0
#include "runner/last_words.hpp"

#include <deque>
#include <fstream>

#include "base/text.hpp"
#include "base/utf8.hpp"

namespace scanmill::runner {

std::string last_words(const std::string& log, std::uint64_t begin, std::size_t count) {
  constexpr std::size_t kLongest = 300;  // of a line
  std::ifstream file(log, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(begin));
  std::deque<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    if (words_of(line).empty()) continue;
    lines.push_back(line.substr(0, kLongest));
    if (lines.size() > count) lines.pop_front();
  }
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : " / ") + line;
  return printable(text);
}

}  // namespace scanmill::runner
