// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "formats/read_whole.hpp"
#include "formats/table.hpp"
#include "store/files.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::formats {
namespace {

template <class T>
std::string bytes_of(T value, bool big = false) {
  std::string text(sizeof(T), '\0');
  std::memcpy(text.data(), &value, sizeof(T));
  if (big) std::reverse(text.begin(), text.end());
  return text;
}

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";

std::string ascii(const std::string& elements, const std::string& body) {
  return "ply\nformat ascii 1.0\n" + elements + "end_header\n" + body;
}
std::string binary(const std::string& elements, const std::string& body, bool big = false) {
  return std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") + " 1.0\n" + elements +
         "end_header\n" + body;
}
std::string point(float x, float y, float z) { return bytes_of(x) + bytes_of(y) + bytes_of(z); }

void expect_failure(const std::string& bytes, const std::string& part) {
  const auto whole = read_whole("a.ply", bytes);
  ASSERT_FALSE(whole.ok()) << "wanted: " << part;
  EXPECT_EQ(whole.error().code, Code::BadInput);
  EXPECT_NE(whole.error().text().find(part), std::string::npos) << whole.error().text();
  EXPECT_EQ(whole.error().where.rfind("a.ply", 0), 0u) << whole.error().text();
}

TEST(ReadPly, TakesAsciiWithOddSpacesAndLineEnds) {
  const auto whole =
      read_whole("a.ply",
                 "ply \r\nformat   ascii 1.0\t\r\ncomment  two  blanks\r\nobj_info num_cols 2\r\n element vertex\t2\r\n"
                 "property float x\r\nproperty   float y\r\nproperty uchar red\r\nproperty float z\r\nend_header\r\n"
                 " 1 2.5 255 -3e1 \r\n\r\n+4\t5 0 6\r\n");
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->header.format, "ply ascii");
  EXPECT_EQ(whole->positions, (std::vector<Vec3>{{1, 2.5, -30}, {4, 5, 6}}));
  EXPECT_EQ(whole->rows, (std::vector<std::uint64_t>{0, 1}));
  EXPECT_TRUE(whole->header.notes.empty());
}

TEST(ReadPly, TakesEveryScalarTypeInBothByteOrders) {
  for (const bool big : {false, true}) {
    const std::string body = bytes_of<std::int8_t>(-3, big) + bytes_of<std::uint16_t>(60000, big) + bytes_of(2.5, big) +
                             bytes_of<std::uint32_t>(7, big) + bytes_of<std::int16_t>(-2, big);
    for (const bool sized : {false, true}) {
      const std::string elements = sized ? "element vertex 1\nproperty int8 y\nproperty uint16 x\nproperty float64 w\n"
                                           "property uint32 z\nproperty int16 q\n"
                                         : "element vertex 1\nproperty char y\nproperty ushort x\nproperty double w\n"
                                           "property uint z\nproperty short q\n";
      const auto whole = read_whole("a.ply", binary(elements, body, big));
      ASSERT_TRUE(whole.ok()) << whole.error().text();
      EXPECT_EQ(whole->positions, (std::vector<Vec3>{{60000, -3, 7}}));
    }
  }
}

TEST(ReadPly, GivesTheSamePointsForFloatsAndDoublesHoweverPacked) {
  std::string packed, padded, wide, big;
  std::vector<Vec3> expected;
  for (int i = 0; i < 70000; ++i) {  // more than one block
    const float x = static_cast<float>(i) * 0.1f, y = -x, z = 1.0f / static_cast<float>(i + 1);
    expected.push_back({x, y, z});
    packed += point(x, y, z);
    padded += point(x, y, z) + "c";
    wide += bytes_of<double>(x) + bytes_of<double>(y) + bytes_of<double>(z);
    big += bytes_of(x, true) + bytes_of(y, true) + bytes_of(z, true);
  }
  const std::string doubles = "property double x\nproperty double y\nproperty double z\n",
                    head = "element vertex 70000\n";
  for (const std::string& file : {binary(head + kXyz, packed), binary(head + kXyz + "property uchar c\n", padded),
                                  binary(head + doubles, wide), binary(head + kXyz, big, true)}) {
    const auto whole = read_whole("a.ply", file);
    ASSERT_TRUE(whole.ok()) << whole.error().text();
    EXPECT_EQ(whole->positions, expected);
    EXPECT_EQ(whole->rows.back(), 69999u);
  }
}

TEST(ReadPly, PassesOverOtherElementsAndListsInAnyOrder) {
  const std::string elements = "element face 2\nproperty list uchar int vertex_indices\nelement vertex 2\n" + kXyz +
                               "property list uchar short more\nelement range_grid 2\nproperty list uchar int v\n";
  const std::string faces = std::string("\x01") + bytes_of<std::int32_t>(7) + std::string(1, '\0');
  const std::string vertices = point(1, 2, 3) + "\x02" + "abcd" + point(4, 5, 6) + std::string(1, '\0');
  const auto whole = read_whole("a.ply", binary(elements, faces + vertices + std::string(2, '\0')));
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->positions, (std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_TRUE(whole->header.has_faces);
  EXPECT_TRUE(whole->header.has_grid);
  const auto text = read_whole("a.ply", ascii(elements, "3 0 1 2\n0\n1 2 3 2 8 9\n4 5 6 0\n0\n1 1\n"));
  ASSERT_TRUE(text.ok()) << text.error().text();
  EXPECT_EQ(text->positions, whole->positions);
}

TEST(ReadPly, CutsRowsWithoutFixedSizeIntoBlocksThatKeepTheirRows) {
  std::string body, text;
  for (int i = 0; i < 150000; ++i) {
    body += std::string(1, static_cast<char>(i % 3)) + std::string(static_cast<std::size_t>(i % 3), 'l') +
            point(static_cast<float>(i), 0, 0);
    text += std::to_string(i) + " 0 0\n" + (i % 1000 == 0 ? "\n" : "");
  }
  const auto lists = read_whole("a.ply", binary("element vertex 150000\nproperty list uchar uchar l\n" + kXyz, body));
  const auto lines = read_whole("a.ply", ascii("element vertex 150000\n" + kXyz, text));
  for (const auto* whole : {&lists, &lines}) {
    ASSERT_TRUE(whole->ok()) << whole->error().text();
    ASSERT_EQ((*whole)->positions.size(), 150000u);
    for (std::size_t i = 0; i < 150000; ++i) {
      ASSERT_EQ((*whole)->rows[i], i);
      ASSERT_EQ((*whole)->positions[i].x, static_cast<double>(i));
    }
  }
}

TEST(ReadPly, DropsAndCountsWhatIsNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const auto whole =
      read_whole("a.ply", binary("element vertex 4\n" + kXyz,
                                 point(1, 2, nan) + point(1, 2, 3) + point(-inf, 0, 0) + point(3e38f, 3e38f, 3e38f)));
  ASSERT_TRUE(whole.ok());
  EXPECT_EQ(whole->not_finite, 2u);
  EXPECT_EQ(whole->rows, (std::vector<std::uint64_t>{1, 3}));
  const auto text = read_whole("a.ply", ascii("element vertex 4\n" + kXyz, "nan 0 0\n1 -inf 0\n1 1.#QNAN 0\n1 2 3"));
  ASSERT_TRUE(text.ok()) << text.error().text();
  EXPECT_EQ(text->not_finite, 3u);
  EXPECT_EQ(text->rows, (std::vector<std::uint64_t>{3}));
}

TEST(ReadPly, NamesThePlaceOfALie) {
  expect_failure(binary("element vertex 1000000000000\n" + kXyz, point(1, 2, 3)), "the file ends after 1");
  expect_failure(binary("element vertex 18446744073709551615\n" + kXyz, point(1, 2, 3)), "the file ends after 1");
  expect_failure(ascii("element vertex 18446744073709551616\n" + kXyz, ""), "a.ply:3");
  expect_failure(ascii("element vertex -1\n" + kXyz, ""), "a.ply:3");
  expect_failure(ascii("element vertex 3\n" + kXyz, "1 2 3\n4 5 6\n"), "the file ends after 2");
  expect_failure(ascii("element vertex 2\n" + kXyz, "1 2 3\n4 5 six\n"), "a.ply:9");
  expect_failure(ascii("element vertex 2\n" + kXyz, "1 2 3\n4 5\n"), "a.ply:9");
  expect_failure(ascii("element vertex 2\n" + kXyz, "1 2 3\n4 5 6 7\n"), "a.ply:9");
  expect_failure(ascii("element vertex 1\nproperty float x\nproperty float y\n", "1 2\n"), "\"z\"");
  expect_failure(ascii("element face 0\nproperty list uchar int v\n", ""), "no element \"vertex\"");
  expect_failure(ascii("element vertex 1\nproperty half x\n", "1\n"), "\"half\"");
  expect_failure(ascii("element vertex 1\n" + kXyz + kXyz, "1\n"), "second time");
  expect_failure("ply\nelement vertex 0\n" + kXyz + "end_header\n", "no format line");
  expect_failure("ply\nformat binary_middle_endian 1.0\n", "a.ply:2");
  expect_failure("", "empty");
  expect_failure("plyx\n", "a.ply:1");
  const std::string lists = "element vertex 1\nproperty list int uchar l\n" + kXyz;
  expect_failure(binary(lists, bytes_of<std::int32_t>(-5) + point(1, 2, 3)), "length -5");
  expect_failure(binary(lists, bytes_of<std::int32_t>(2000000000) + point(1, 2, 3)), "ends after 0");
}

// A count below what the file holds would lose points unseen.
TEST(ReadPly, RefusesRowsBehindTheDeclaredOnes) {
  const std::string element = "element vertex 1\n" + kXyz;
  expect_failure(ascii(element, "1 2 3\n4 5 6\n"), "a.ply:9: the file goes on for 6 bytes behind the 1 rows");
  expect_failure(binary(element, point(1, 2, 3) + point(4, 5, 6)), "goes on for 12 bytes behind the 1 rows");
  for (const std::string& harmless : {ascii(element, "1 2 3\n\n  \n"), binary(element, point(1, 2, 3) + "\n")}) {
    const auto whole = read_whole("a.ply", harmless);
    ASSERT_TRUE(whole.ok()) << whole.error().text();
    EXPECT_EQ(whole->positions.size(), 1u);
  }
}

TEST(ReadPly, NotesWhatItSkipped) {
  const auto rest = read_whole("a.ply", binary("element vertex 1\n" + kXyz + "extra line\n", point(1, 2, 3) + "rest"));
  ASSERT_TRUE(rest.ok()) << rest.error().text();
  ASSERT_EQ(rest->header.notes.size(), 2u);
  EXPECT_NE(rest->header.notes[0].find("line 7"), std::string::npos) << rest->header.notes[0];
  EXPECT_NE(rest->header.notes[1].find("4 bytes behind"), std::string::npos) << rest->header.notes[1];
  const auto none = read_whole("a.ply", ascii("element vertex 0\n" + kXyz, ""));
  ASSERT_TRUE(none.ok());
  EXPECT_EQ(none->header.rows, 0u);
}

TEST(ReadPly, NeverGivesFewerPointsThanDeclaredWhenCutAnywhere) {
  const std::string faces = "element face 1\nproperty list uchar int v\n";
  const std::string files[] = {
      binary("element vertex 3\n" + kXyz, point(1, 2, 3) + point(4, 5, 6) + point(7, 8, 9)),
      binary("element vertex 2\n" + kXyz + "property list uchar uchar l\n" + faces,
             point(1, 2, 3) + "\x01" + "a" + point(4, 5, 6) + "\x02" + "ab" + "\x01" + "abcd", true),
      ascii(faces + "element vertex 3\n" + kXyz, "3 1 2 3\n1 2 3\n4 5 6\n7 8 9\n")};
  for (const std::string& file : files) {
    const auto complete = read_whole("a.ply", file);
    ASSERT_TRUE(complete.ok()) << complete.error().text();
    for (std::size_t cut = 0; cut < file.size(); ++cut) {
      const auto whole = read_whole("a.ply", file.substr(0, cut));
      if (whole.ok())
        EXPECT_EQ(whole->positions.size(), complete->positions.size()) << "cut at " << cut;
      else
        EXPECT_TRUE(whole.error().code == Code::BadInput || whole.error().code == Code::Unsupported)
            << whole.error().text();
    }
  }
}

TEST(ReadPlyTable, GivesColumnsByName) {
  const std::string elements =
      "comment bin_mm 0.5\nelement vertex 1\n" + kXyz + "element moment 2\nproperty int count\nproperty double sum\n";
  const std::string body =
      point(1, 2, 3) + bytes_of<std::int32_t>(4) + bytes_of(0.25) + bytes_of<std::int32_t>(-5) + bytes_of(1e300);
  for (const std::string& file : {binary(elements, body), ascii(elements, "1 2 3\n4 0.25\n\n-5 1e300\n")}) {
    const auto table = read_ply_table(*memory_source("a.ply", file), "moment");
    ASSERT_TRUE(table.ok()) << table.error().text();
    EXPECT_EQ(table->names, (std::vector<std::string>{"count", "sum"}));
    EXPECT_EQ(*table->find("count"), (std::vector<double>{4, -5}));
    EXPECT_EQ(*table->find("sum"), (std::vector<double>{0.25, 1e300}));
    EXPECT_EQ(table->find("x"), nullptr);
    EXPECT_EQ(table->comments, (std::vector<std::string>{"bin_mm 0.5"}));
    EXPECT_FALSE(read_ply_table(*memory_source("a.ply", file), "bin").ok());
    EXPECT_FALSE(read_ply_table(*memory_source("a.ply", file.substr(0, file.size() - 8)), "moment").ok());
  }
}

TEST(ReadPly, ReadsTheCollectedFiles) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  const std::pair<const char*, std::size_t> expected[] = {{"cube.ply", 8},
                                                          {"cube_binary.ply", 8},
                                                          {"cube_binary_header_with_RN_newline.ply", 8},
                                                          {"cube_binary_starts_with_nl.ply", 8},
                                                          {"cube_uv.ply", 24},
                                                          {"float-color.ply", 3},
                                                          {"int_point_cloud.ply", 16},
                                                          {"metadata.ply", 4},
                                                          {"multi.ply", 4},
                                                          {"platonic_shelf.ply", 50},
                                                          {"platonic_shelf_ascii.ply", 50},
                                                          {"platonic_shelf_big_endian.ply", 50},
                                                          {"points.ply", 4},
                                                          {"points_ascii.ply", 5},
                                                          {"points_ascii_with_lists.ply", 5},
                                                          {"points_bin.ply", 5},
                                                          {"points_emptyface.ply", 1024},
                                                          {"reference.ply", 845},
                                                          {"simple_binary.ply", 3},
                                                          {"simple_text.ply", 3},
                                                          {"test_extra_whitespace.ply", 3},
                                                          {"test_more_datatypes.ply", 3},
                                                          {"text_extradim.ply", 1}};
  for (const auto& [name, points] : expected) {
    const auto source = store::open_file(data + "/formats/ply/" + name, name);
    ASSERT_TRUE(source.ok()) << name;
    const auto whole = read_whole(*source);
    ASSERT_TRUE(whole.ok()) << whole.error().text();
    EXPECT_EQ(whole->positions.size(), points) << name;
  }
  for (const char* name : {"issue623.ply", "sized_dims.ply", "unsized_dims.ply"}) {  // rows and header disagree; no z
    const auto whole = read_whole(*store::open_file(data + "/formats/ply/" + name, name));
    ASSERT_FALSE(whole.ok()) << name;
    EXPECT_EQ(whole.error().code, Code::BadInput) << name;
  }
}

}  // namespace
}  // namespace scanmill::formats
