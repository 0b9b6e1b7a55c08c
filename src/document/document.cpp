// SPDX-License-Identifier: Apache-2.0
#include "document/document.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "base/utf8.hpp"

namespace scanmill::document {

const char* Node::kind() const {
  static constexpr const char* kNames[] = {"nothing", "true/false", "a whole number", "a number",
                                           "a text",  "a list",     "a map"};
  return kNames[value_.index()];
}

const Node* Node::find(std::string_view key) const {
  if (!is_map()) return nullptr;
  for (const Entry& entry : entries())
    if (entry.key == key) return &entry.value;
  return nullptr;
}
Node* Node::find(std::string_view key) { return const_cast<Node*>(static_cast<const Node*>(this)->find(key)); }

Node& Node::set(std::string_view key, Node value) {
  if (is_null()) value_ = Map{};
  if (Node* present = find(key)) return *present = std::move(value);
  entries().push_back({std::string(key), {}, std::move(value)});
  return entries().back().value;
}

std::string place(const std::string& name, Mark mark) {
  return name + ":" + std::to_string(mark.line) + ":" + std::to_string(mark.column);
}

namespace {

void append_string(std::string& out, const std::string& text) {
  static constexpr char kHex[] = "0123456789abcdef";
  out += '"';
  std::size_t sound = 0;  // bytes before this one are UTF-8
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x80 && at >= sound) {
      // Names of files may be any bytes, JSON may not: no reader would take the document.
      std::uint32_t value = 0;
      const std::size_t size = utf8_sequence(text, at, value);
      sound = at + size;
      if (size == 0) {
        out += {'\\', '\\', 'x', kHex[byte >> 4], kHex[byte & 15]};
        continue;
      }
    }
    switch (c) {
      case '"':
        out += "\\\"";
        break;
      case '\\':
        out += "\\\\";
        break;
      case '\n':
        out += "\\n";
        break;
      case '\r':
        out += "\\r";
        break;
      case '\t':
        out += "\\t";
        break;
      default:
        if (byte < 0x20) {
          out += "\\u00";
          out += kHex[byte >> 4];
          out += kHex[byte & 15];
        } else {
          out += c;
        }
    }
  }
  out += '"';
}

std::string number_json(const Node& node) {
  if (node.is_integer()) return std::to_string(node.as_integer());
  const double value = node.as_number();
  if (!std::isfinite(value)) return "null";  // JSON has no other word
  if (value == std::floor(value) && std::abs(value) < 0x1p53) return std::to_string(static_cast<std::int64_t>(value));
  return number_text(value);
}

void write_json(std::string& out, const Node& node, int indent, int depth, bool sorted) {
  auto line = [&](int level) {
    if (indent < 0) return;
    out += '\n';
    out.append(static_cast<std::size_t>(level * indent), ' ');
  };
  if (node.is_null())
    out += "null";
  else if (node.is_bool())
    out += node.as_bool() ? "true" : "false";
  else if (node.is_number())
    out += number_json(node);
  else if (node.is_string())
    append_string(out, node.as_string());
  else if (node.is_sequence()) {
    out += '[';
    bool first = true;
    const bool flat = std::all_of(node.items().begin(), node.items().end(),
                                  [](const Node& n) { return !n.is_map() && !n.is_sequence(); });
    for (const Node& item : node.items()) {
      if (!first) out += indent >= 0 && flat ? ", " : ",";
      first = false;
      if (!flat) line(depth + 1);
      write_json(out, item, indent, depth + 1, sorted);
    }
    if (!first && !flat) line(depth);
    out += ']';
  } else {
    out += '{';
    std::vector<const Node::Entry*> order;
    for (const Node::Entry& entry : node.entries()) order.push_back(&entry);
    if (sorted) std::sort(order.begin(), order.end(), [](auto* a, auto* b) { return a->key < b->key; });
    bool first = true;
    for (const Node::Entry* entry : order) {
      if (!first) out += ',';
      first = false;
      line(depth + 1);
      append_string(out, entry->key);
      out += indent >= 0 ? ": " : ":";
      write_json(out, entry->value, indent, depth + 1, sorted);
    }
    if (!first) line(depth);
    out += '}';
  }
}

bool is_flat(const Node& node) {
  if (node.is_map()) return node.entries().empty();
  if (!node.is_sequence()) return true;
  return std::all_of(node.items().begin(), node.items().end(),
                     [](const Node& n) { return !n.is_map() && !n.is_sequence(); });
}

void write_yaml(std::string& out, const Node& node, int depth) {
  auto pad = [&] { out.append(static_cast<std::size_t>(depth * 2), ' '); };
  auto value_of = [&](const Node& value) {
    if (is_flat(value)) {
      out += ' ';
      write_json(out, value, 0, 0, false);
      out += '\n';
    } else {
      out += '\n';
      write_yaml(out, value, depth + 1);
    }
  };
  if (is_flat(node)) {
    pad();
    write_json(out, node, 0, 0, false);
    out += '\n';
  } else if (node.is_sequence()) {
    for (const Node& item : node.items()) {
      pad();
      out += '-';
      value_of(item);
    }
  } else {
    for (const Node::Entry& entry : node.entries()) {
      pad();
      const bool plain = !entry.key.empty() &&
                         entry.key.find_first_not_of(
                             "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.") == std::string::npos;
      if (plain)
        out += entry.key;
      else
        append_string(out, entry.key);
      out += ':';
      value_of(entry.value);
    }
  }
}

}  // namespace

std::string to_json(const Node& node, int indent) {
  std::string out;
  write_json(out, node, indent, 0, false);
  return out;
}

std::string to_canonical_json(const Node& node) {
  std::string out;
  write_json(out, node, -1, 0, true);
  return out;
}

std::string to_yaml(const Node& node) {
  std::string out;
  write_yaml(out, node, 0);
  return out;
}

bool same_values(const Node& a, const Node& b) {
  if (a.is_map() && b.is_map())
    return std::equal(
        a.entries().begin(), a.entries().end(), b.entries().begin(), b.entries().end(),
        [](const Node::Entry& x, const Node::Entry& y) { return x.key == y.key && same_values(x.value, y.value); });
  if (a.is_sequence() && b.is_sequence())
    return std::equal(a.items().begin(), a.items().end(), b.items().begin(), b.items().end(), same_values);
  if (a.is_string() && b.is_string()) return a.as_string() == b.as_string();
  return to_canonical_json(a) == to_canonical_json(b);
}

}  // namespace scanmill::document
