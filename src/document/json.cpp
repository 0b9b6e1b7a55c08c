// SPDX-License-Identifier: Apache-2.0
// The wall around nlohmann-json: reading only; writing is a page of our own in document.cpp. Its events become our tree
// one by one, so that depth and size are limited before memory or stack are spent.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "document/document.hpp"

namespace scanmill::document {
namespace {

constexpr std::size_t kMaxDepth = 64;
constexpr std::size_t kMaxNodes = 1000000;

class Builder final : public nlohmann::json_sax<nlohmann::json> {
 public:
  Node root;
  std::string problem;  // empty while all is well

  bool null() override { return place(Node()); }
  bool boolean(bool value) override { return place(Node(value)); }
  bool number_integer(number_integer_t value) override { return place(Node(std::int64_t{value})); }
  bool number_unsigned(number_unsigned_t value) override {
    return place(value <= INT64_MAX ? Node(static_cast<std::int64_t>(value)) : Node(static_cast<double>(value)));
  }
  bool number_float(number_float_t value, const string_t&) override { return place(Node(value)); }
  bool string(string_t& value) override { return place(Node(std::move(value))); }
  bool binary(binary_t&) override { return refuse("binary values are not used in scanmill files"); }
  bool start_object(std::size_t) override { return open(Node::map()); }
  bool start_array(std::size_t) override { return open(Node::sequence()); }
  bool end_array() override { return close(); }
  bool key(string_t& value) override {
    stack_.back().key = std::move(value);
    return true;
  }
  bool end_object() override {
    std::vector<std::string_view> keys;
    for (const Node::Entry& entry : stack_.back().node.entries()) keys.push_back(entry.key);
    std::sort(keys.begin(), keys.end());
    const auto twice = std::adjacent_find(keys.begin(), keys.end());
    if (twice != keys.end()) return refuse("the key '" + std::string(*twice) + "' stands twice in one map; remove one");
    return close();
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& error) override {
    return refuse(std::string("not readable as JSON: ") + error.what());
  }

 private:
  struct Level {
    Node node;
    std::string key;  // of the value to come
  };
  std::vector<Level> stack_;
  std::size_t nodes_ = 0;

  bool refuse(std::string sentence) {
    problem = std::move(sentence);
    return false;
  }
  bool place(Node node) {
    if (++nodes_ > kMaxNodes) return refuse("more than a million values");
    if (stack_.empty())
      root = std::move(node);
    else if (stack_.back().node.is_map())
      stack_.back().node.entries().push_back({std::move(stack_.back().key), {}, std::move(node)});
    else
      stack_.back().node.push(std::move(node));
    return true;
  }
  bool open(Node node) {
    if (stack_.size() >= kMaxDepth) return refuse("nested deeper than 64 levels");
    stack_.push_back({std::move(node), {}});
    return true;
  }
  bool close() {
    Node node = std::move(stack_.back().node);
    stack_.pop_back();
    return place(std::move(node));
  }
};

}  // namespace

Result<Node> parse_json(std::string_view text, const std::string& name) {
  try {
    Builder builder;
    if (nlohmann::json::sax_parse(text.begin(), text.end(), &builder)) return std::move(builder.root);
    return fail(Code::BadParameter, builder.problem, name);
  } catch (const nlohmann::json::exception& error) {
    return fail(Code::BadParameter, std::string("not readable as JSON: ") + error.what(), name);
  }
}

}  // namespace scanmill::document
