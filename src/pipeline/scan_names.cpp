// SPDX-License-Identifier: Apache-2.0
#include "pipeline/scan_names.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/digest.hpp"

namespace scanmill::pipeline {
namespace {

/// Folders and logs are named after scans, with a few more bytes, and 255 is what file systems take. Longer parts keep
/// their beginning and get a digest of the whole in place of the rest.
std::string shortened(const std::string& encoded_path, const std::string& path) {
  constexpr std::size_t kLongest = 200, kKept = 150;
  std::string out;
  for (std::size_t begin = 0; begin <= encoded_path.size();) {
    const std::size_t end = std::min(encoded_path.find('/', begin), encoded_path.size());
    std::string part = encoded_path.substr(begin, end - begin);
    if (part.size() > kLongest) {
      std::size_t cut = kKept;
      while (part[cut - 1] == '%' || part[cut - 2] == '%') --cut;
      part = part.substr(0, cut) + "-" + sha256_hex(path).substr(0, 16);
    }
    out += (begin > 0 ? "/" : "") + part;
    begin = end + 1;
  }
  return out;
}

std::string encoded(const std::string& path) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool safe = (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' ||
                      c == '_' || c == '/' || c == '-';
    if (safe) {
      out += c;
    } else {
      out += '%';
      out += kHex[byte >> 4];
      out += kHex[byte & 15];
    }
  }
  return shortened(out, path);
}

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

std::string without_suffix(const std::string& path) {
  const auto slash = path.rfind('/');
  const auto dot = path.rfind('.');
  const std::size_t begin = slash == std::string::npos ? 0 : slash + 1;
  return dot == std::string::npos || dot <= begin ? path : path.substr(0, dot);
}

}  // namespace

std::vector<std::string> scan_names(const std::vector<std::string>& paths) {
  std::vector<std::string> names;
  std::set<std::string> folders;
  for (const std::string& path : paths) {
    names.push_back(encoded(without_suffix(path)));
    for (auto slash = path.find('/'); slash != std::string::npos; slash = path.find('/', slash + 1))
      folders.insert(lower(encoded(path.substr(0, slash))));
  }
  // "a.ply" may meet "a.ply.xyz" once it keeps its suffix, so this goes on until no two meet; full paths never do.
  for (bool changed = true; changed;) {
    changed = false;
    std::map<std::string, int> uses;
    for (const std::string& name : names) ++uses[name];
    for (std::size_t i = 0; i < names.size(); ++i) {
      if ((uses[names[i]] == 1 && !folders.contains(lower(names[i]))) || names[i] == encoded(paths[i])) continue;
      names[i] = encoded(paths[i]);
      changed = true;
    }
  }
  return names;
}

std::vector<std::string> case_clashes(const std::vector<std::string>& names, const std::vector<std::string>& paths) {
  std::map<std::string, std::vector<std::size_t>> same;
  for (std::size_t i = 0; i < names.size(); ++i) same[lower(names[i])].push_back(i);
  std::vector<std::string> clashes(names.size());
  for (const auto& [name, group] : same)
    for (std::size_t k = 0; group.size() > 1 && k < group.size(); ++k)
      clashes[group[k]] = paths[group[k]] + " and " + paths[group[k > 0 ? 0 : 1]] +
                          " make scans whose names differ by letter case only; rename one (their results would "
                          "overwrite each other on file systems that ignore case)";
  return clashes;
}

}  // namespace scanmill::pipeline
