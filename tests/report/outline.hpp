// SPDX-License-Identifier: Apache-2.0
// A strict reader of the pages we write.
#pragma once
#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace scanmill::report {

/// Tags in the order of the page; a message in `fault` at the first that does not fit.
struct Outline {
  std::vector<std::string> opened;  // name and attributes
  std::string text;                 // between the tags, entities kept
  std::string fault;
};

/// Strict reading: every tag closed or ended by "/>", attributes in double quotes, no stray < > or &.
inline Outline outline_of(const std::string& page) {
  Outline o;
  std::vector<std::string> stack;
  const std::set<std::string> entities{"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
  const auto check_text = [&](const std::string& text) {
    for (std::size_t at = text.find('&'); at != std::string::npos; at = text.find('&', at + 1))
      if (entities.count(text.substr(at, text.find(';', at) - at + 1)) == 0)
        o.fault += " entity near " + text.substr(at, 12);
    if (text.find('>') != std::string::npos) o.fault += " stray > in " + text;
  };
  std::size_t at = page.find("<html");
  if (page.substr(0, at) != "<!DOCTYPE html>\n") o.fault = "no doctype";
  while (at < page.size() && o.fault.empty()) {
    if (!stack.empty() && stack.back() == "script" && page.compare(at, 9, "</script>") != 0) {
      at = std::min(page.find("</script>", at), page.size());  // its text is no markup
      continue;
    }
    if (page[at] != '<') {
      const std::size_t end = std::min(page.find('<', at), page.size());
      const std::string text = page.substr(at, end - at);
      if (stack.empty() || stack.back() != "style") check_text(text);
      o.text += text;
      at = end;
      continue;
    }
    std::size_t end = at + 1;  // a '>' inside quotes does not end the tag
    for (bool quoted = false; end < page.size() && (quoted || page[end] != '>'); ++end) quoted ^= page[end] == '"';
    const std::string tag = page.substr(at + 1, end - at - 1);
    at = end + 1;
    const std::string name = tag.substr(0, tag.find_first_of(" />", 1));
    if (tag[0] == '/') {
      if (stack.empty() || "/" + stack.back() != tag) {
        o.fault = "</" + tag.substr(1) + "> closes " + (stack.empty() ? "nothing" : stack.back());
        break;
      }
      stack.pop_back();
      continue;
    }
    o.opened.push_back(tag);
    if (std::count(tag.begin(), tag.end(), '"') % 2 != 0) o.fault = "quotes in " + tag;
    if (tag.back() != '/') stack.push_back(name);
  }
  if (o.fault.empty() && !stack.empty()) o.fault = stack.back() + " is never closed";
  return o;
}

inline std::size_t count_of(const std::string& page, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = page.find(what); at != std::string::npos; at = page.find(what, at + 1)) ++count;
  return count;
}

}  // namespace scanmill::report
