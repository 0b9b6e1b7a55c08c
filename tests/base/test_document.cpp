// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "base/context.hpp"
#include "base/text.hpp"
#include "document/document.hpp"

namespace scanmill {
namespace {

using document::Node;

TEST(ParseYaml, MarksKeysAndValues) {
  const auto tree = document::parse_yaml("a: 1\nb:\n  c: [1, 2.5, yes]\n", "job.yaml");
  ASSERT_TRUE(tree.ok()) << tree.error().text();
  const Node* c = tree->find("b")->find("c");
  ASSERT_NE(c, nullptr);
  EXPECT_EQ(c->mark.line, 3);
  EXPECT_EQ(c->mark.column, 6);
  EXPECT_TRUE(c->items()[0].is_integer());
  EXPECT_EQ(c->items()[1].as_number(), 2.5);
  EXPECT_TRUE(c->items()[2].is_string());  // only true and false are booleans
}

TEST(ParseYaml, ReadsLeadingZeroAsDecimal) {
  const auto tree = document::parse_yaml("a: 010\nb: '1'\n", "x");
  ASSERT_TRUE(tree.ok());
  EXPECT_EQ(tree->find("a")->as_integer(), 10);
  EXPECT_TRUE(tree->find("b")->is_string());
}

TEST(ParseYaml, RefusesDuplicateKeysAliasesAndDepth) {
  for (const std::string text : {"a: 1\na: 2\n", "a: &x 1\nb: *x\n", "a: [1\n"}) {
    const auto tree = document::parse_yaml(text, "job.yaml");
    ASSERT_FALSE(tree.ok()) << text;
    EXPECT_EQ(tree.error().code, Code::BadParameter);
    EXPECT_EQ(tree.error().where.rfind("job.yaml:", 0), 0u) << tree.error().where;
  }
  EXPECT_FALSE(document::parse_yaml(std::string(200, '['), "x").ok());
}

TEST(ToYaml, ReadsBackEqual) {
  Node tree = Node::map();
  tree.set("name", "a \"b\"\n");
  Node list = Node::sequence();
  for (const double v : {0.1, 1e-300, -3.0}) list.push(v);
  tree.set("numbers", list);
  Node inner = Node::map();
  inner.set("deep", Node::sequence());
  inner.find("deep")->push(inner);
  tree.set("inner", inner);
  const auto again = document::parse_yaml(document::to_yaml(tree), "x");
  ASSERT_TRUE(again.ok()) << again.error().text() << "\n" << document::to_yaml(tree);
  EXPECT_EQ(document::to_canonical_json(*again), document::to_canonical_json(tree));
}

TEST(CanonicalJson, SortsKeysAndKeepsNumbersShort) {
  const auto tree = document::parse_json(R"({"b": 1.0, "a": [0.1, 1e20, true, null]})", "x");
  ASSERT_TRUE(tree.ok());
  EXPECT_EQ(document::to_canonical_json(*tree), R"({"a":[0.1,1e+20,true,null],"b":1})");
}

TEST(ToJson, IsUtf8WhateverATextHolds) {
  EXPECT_EQ(to_json(Node("\xc3\x9f\xf0\x9f\x94\xa9\x7f")), "\"\xc3\x9f\xf0\x9f\x94\xa9\x7f\"");
  EXPECT_EQ(to_json(Node("a\xff\xc3\xc3\xa4\xed\xa0\x80")), "\"a\\\\xff\\\\xc3\xc3\xa4\\\\xed\\\\xa0\\\\x80\"");
  Node map = Node::map();
  map.set("key \xe4", "value \xe4");
  EXPECT_TRUE(document::parse_json(to_json(map), "x").ok());
  EXPECT_EQ(to_canonical_json(map), "{\"key \\\\xe4\":\"value \\\\xe4\"}");
}

TEST(ParseJson, RefusesWhatYamlRefuses) {
  auto refused = [](const std::string& text, const std::string& words) {
    const auto tree = document::parse_json(text, "x.json");
    ASSERT_FALSE(tree.ok());
    EXPECT_EQ(tree.error().where, "x.json");
    EXPECT_NE(tree.error().message.find(words), std::string::npos) << tree.error().message;
  };
  refused(std::string(200000, '['), "deeper than 64");
  refused(R"({"a": 1, "b": 2, "a": 3})", "'a' stands twice");
  refused(R"({"a": 1,})", "not readable as JSON");
  refused("", "not readable as JSON");
}

TEST(ParseJson, KeepsOrderNestingAndWholeNumbers) {
  const std::string text = R"({"z":[1,[],{}],"a":{"b":-9007199254740993,"c":"x"},"m":null})";
  const auto tree = document::parse_json(text, "x");
  ASSERT_TRUE(tree.ok()) << tree.error().text();
  EXPECT_EQ(document::to_json(*tree), text);
}

TEST(ParseYaml, KeepsWholeNumbersThatNoDoubleHolds) {
  const auto tree = document::parse_yaml("a: 123456789012345678\nb: -9007199254740993\nc: +7\nd: +-7\n", "x");
  ASSERT_TRUE(tree.ok()) << tree.error().text();
  EXPECT_EQ(tree->find("a")->as_integer(), 123456789012345678);
  EXPECT_EQ(tree->find("b")->as_integer(), -9007199254740993);
  EXPECT_EQ(tree->find("c")->as_integer(), 7);
  EXPECT_TRUE(tree->find("d")->is_string());
}

TEST(ParseSize, KnowsBinaryUnits) {
  EXPECT_EQ(parse_size("512M"), 512ull << 20);
  EXPECT_EQ(parse_size("1.5GiB"), 3ull << 29);
  EXPECT_EQ(parse_size("4096"), 4096u);
  EXPECT_FALSE(parse_size("2X").has_value());
  EXPECT_FALSE(parse_size("").has_value());
}

TEST(NearestName, FindsTheMisspeltKey) {
  constexpr std::string_view kKeys[] = {"bin_mm", "origin", "target_points"};
  EXPECT_EQ(nearest_name("bin_m", kKeys), "bin_mm");
  EXPECT_EQ(nearest_name("bin", kKeys), "bin_mm");  // cut short
  EXPECT_EQ(nearest_name("lode", kKeys), "");
  EXPECT_EQ(nearest_name("xyzzy", kKeys), "");
}

TEST(ChunkLoop, RunsEveryChunkOnceWithWorkerInRange) {
  const ChunkLoop loop(3);
  std::vector<int> hits(1000, 0);
  std::atomic<int> worst{0};
  loop.run(hits.size(), [&](std::size_t chunk, int worker) {
    ++hits[chunk];
    int seen = worst.load();
    while (worker > seen && !worst.compare_exchange_weak(seen, worker)) {
    }
  });
  for (const int h : hits) EXPECT_EQ(h, 1);
  EXPECT_LT(worst.load(), 3);
}

}  // namespace
}  // namespace scanmill
