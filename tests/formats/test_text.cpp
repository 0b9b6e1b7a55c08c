// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <set>

#include "base/random.hpp"
#include "formats/conf.hpp"
#include "formats/decimal.hpp"
#include "formats/probe.hpp"
#include "formats/read_whole.hpp"
#include "store/files.hpp"
#include "support/temp_folder.hpp"

namespace scanmill::formats {
namespace {

using Rows = std::vector<std::uint64_t>;
using Points = std::vector<Vec3>;

void expect_failure(const std::string& bytes, const std::string& part) {
  const auto whole = read_whole("a.xyz", bytes);
  ASSERT_FALSE(whole.ok()) << "wanted: " << part;
  EXPECT_EQ(whole.error().code, Code::BadInput);
  EXPECT_NE(whole.error().text().find(part), std::string::npos) << whole.error().text();
}

TEST(ParseDecimal, GivesTheBitsOfFromChars) {
  Random random(1, 2, 3);
  for (int i = 0; i < 200000; ++i) {
    char text[64];
    const double wanted = std::bit_cast<double>(random.next());
    const double number = i % 2 == 0 ? (random.uniform() - 0.5) * 2000 : wanted;
    const auto end =
        i % 4 < 2 ? std::to_chars(text, text + 64, number)
                  : std::to_chars(text, text + 64, (random.uniform() - 0.5) * 1e6, std::chars_format::fixed, i % 12);
    double expected = 0, value = 1;
    if (std::from_chars(text, end.ptr, expected).ec != std::errc{}) continue;
    ASSERT_EQ(parse_decimal(text, end.ptr, value), end.ptr) << std::string(text, end.ptr);
    if (expected == expected) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(value), std::bit_cast<std::uint64_t>(expected))
          << std::string(text, end.ptr);
    }
  }
}

TEST(ParseDecimal, RefusesWhatIsNoNumber) {
  for (const std::string text : {"", "+", "-", ".", "e5", "+-1", "--1", "abc", "1.#"}) {
    double value = 0;
    const char* stop = parse_decimal(text.data(), text.data() + text.size(), value);
    EXPECT_TRUE(stop == nullptr || stop != text.data() + text.size()) << text;
  }
  for (const std::string text :
       {"+1", "-1.", ".5", "1e5", "1E-400", "1e400", "nan", "-INF", "1.#QNAN", "123456789012345678901234567890"}) {
    double value = 0;
    EXPECT_EQ(parse_decimal(text.data(), text.data() + text.size(), value), text.data() + text.size()) << text;
  }
}

TEST(ReadText, TakesEverySeparatorCommentsAndExtraColumns) {
  const auto whole = read_whole(
      "a.xyz", "# a comment\n1 2 3\r\n\r\n  4,5,6,7\n// more\n;x\n!x\n%x\n7;8;9\t10\n+1\t-2 , 3.5 red\n1 , 2 , 3\n");
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->positions, (Points{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {1, -2, 3.5}, {1, 2, 3}}));
  EXPECT_EQ(whole->rows, (Rows{2, 4, 9, 10, 11}));
  EXPECT_EQ(whole->header.rows, 5u);
  EXPECT_EQ(whole->header.row_meaning, RowMeaning::LineFromOne);
}

TEST(ReadText, LetsAHeaderChooseTheColumns) {
  const Points expected{{1, 2, 3}};
  for (const char* text :
       {"\"Z\",\"id\",\"X\",\"Y\"\n3,9,1,2\n", "z y x\n3 2 1\n", "// id x y z\n9 1 2 3\n",
        "some scanner\nX Y Z\n1 2 3\n", "\xef\xbb\xbfx,y,z\n1,2,3", "P1 1 2 3\n", "intensity;y;x;z\nfoo;2;1;3\n"}) {
    const auto whole = read_whole("a.csv", text);
    ASSERT_TRUE(whole.ok()) << text << whole.error().text();
    EXPECT_EQ(whole->positions, expected) << text;
  }
  // A comment with another number of words names nothing.
  EXPECT_EQ(read_whole("a.xyz", "# z y x\n1 2 3 4\n")->positions, expected);
}

TEST(ReadText, SplitsAHeaderAsItsNumbersAreSplit) {
  const Points expected{{-2.5, 7, 19}, {1, 2, 3}};
  const std::pair<std::string, std::string> files[] = {
      {"Point No,X,Y,Z,I,R\n1,-2.5,7,19,5,6\n2,1,2,3,5,6\n", "2, 3 and 4 (X, Y, Z)"},
      {"Point No;X;Y;Z;I;R\n1;-2.5;7;19;5;6\n2;1;2;3;5;6\n", "2, 3 and 4 (X, Y, Z)"},
      {"Point No,X,Y,Z\nPt 1,-2.5,7,19\nPt 2,1,2,3\n", "2, 3 and 4"},
      {"X [mm],Y [mm],Z [mm],R,G,B,u,v\n-2.5,7,19,1,2,3,4,5\n1,2,3,1,2,3,4,5\n", ""},
      {"X [mm]\tY [mm]\tZ [mm]\tR\tG\tB\n-2.5\t7\t19\t1\t2\t3\n1\t2\t3\t1\t2\t3\n", ""},
      {"X [mm] Y [mm] Z [mm] R G B\n-2.5 7 19 1 2 3\n1 2 3 1 2 3\n", ""},
      {"I,Z (mm),Y_mm,x/mm\n0,19,7,-2.5\n0,3,2,1\n", "4, 3 and 2 (x/mm, Y_mm, Z (mm))"},
      {"Feature,Side,X,Y,Z\nhole 1,left,-2.5,7,19\nhole 2,right,1,2,3\n", "3, 4 and 5"},
      {"Id\tRemark\tX\tY\tZ\n7\tall well\t-2.5\t7\t19\n8\t\t1\t2\t3\n", "3, 4 and 5"},
      {"Scan X of part 7, Y axis up, Z out\n-2.5, 7, 19, 17\n1, 2, 3, 17\n", "no line names x, y and z"},
      {"Scan X of part 7, Y axis up, Z out\n-2.5 7 19 1 2 3 4 5 6 7 8\n1 2 3 1 2 3 4 5 6 7 8\n", "no line names"},
      {"Hole 1,-2.5,7,19\nHole 2,1,2,3\n", "2, 3 and 4, the first that hold numbers"},
      {"Export of X and Y and Z\nZ Y X\n19 7 -2.5\n3 2 1\n", "3, 2 and 1"}};
  for (const auto& [text, note] : files) {
    const auto whole = read_whole("a.csv", text);
    ASSERT_TRUE(whole.ok()) << text << whole.error().text();
    EXPECT_EQ(whole->positions, expected) << text;
    std::string notes;
    for (const std::string& line : whole->header.notes) notes += line + "\n";
    EXPECT_NE(notes.find(note), std::string::npos) << text << notes;
    EXPECT_EQ(note.empty(), notes.find("columns") == std::string::npos) << text << notes;
  }
  // An empty cell holds no number, whatever stands behind it.
  expect_failure("X\tY\tZ\tI\n1\t2\t3\t4\n1\t\t3\t4\n", "a.xyz:3");
  expect_failure("X,Y,Z,I\n1,2,3,4\n1 2,3,4\n", "a.xyz:3");
  expect_failure("Point No X Y Z\n1 2 3 4\n", "5 words in the column names \"Point No X Y Z\" over 4 columns");
}

TEST(ReadText, TakesAPointCountThatIsTrueAndNoOther) {
  EXPECT_EQ(read_whole("a.pwn", "2\n1 2 3 0 0 1\n4 5 6 0 0 1\n")->positions.size(), 2u);
  EXPECT_EQ(read_whole("a.pts", "0\n")->header.rows, 0u);
  expect_failure("3\n1 2 3\n4 5 6\n", "declares 3 points, the file holds 2");
  expect_failure("1\n1 2 3\n4 5 6\n", "declares 1 points, the file holds 2");
  expect_failure("-1\n1 2 3\n", "a.xyz:1");
  expect_failure("2.5\n1 2 3\n", "a.xyz:1");
}

TEST(ReadText, CountsWordsThatAreNotFinite) {
  const auto whole = read_whole("a.xyz", "1 2 nan\nNaN NaN NaN\n1 2 3\n-inf 0 0\n1e999 0 0\n");
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->not_finite, 4u);
  EXPECT_EQ(whole->points_read, 5u);
  EXPECT_EQ(whole->rows, (Rows{3}));
}

TEST(ReadText, NamesTheLineThatIsWrong) {
  expect_failure("1 2 3\n4 5\n", "a.xyz:2: found \"4 5\", wanted three numbers");
  expect_failure("1 2 3\n4 five 6\n", "a.xyz:2");
  expect_failure("1 2 3\n4 5 6x\n", "a.xyz:2");
  expect_failure("1,2,3\n4,,6,7\n", "a.xyz:2");
  expect_failure("1 2 3\nx y z\n", "a.xyz:2");
  expect_failure("1 2\n", "a.xyz:1");
  expect_failure("x,y,x\n1,2,3\n", "2 columns named x");
  expect_failure("1,5;2,5;3,5\n", "decimal commas");
  expect_failure("1,5 2,5 3,5\n", "decimal commas");
  expect_failure("1.234,5;2.345,6;3.456,7\n", "decimal commas");
  expect_failure("1.234,5 2.345,6 -3.456,7e-1\n", "decimal commas");
  expect_failure("x;y;z\n1.234,5;2;3\n", "decimal commas");
  expect_failure("X [m],Y [mm],Z [cm]\n1,2,3\n",
                 "a.xyz:1: found the columns \"X [m]\", \"Y [mm]\" and \"Z [cm]\", wanted x, y and z in one unit");
  expect_failure("0.1D+01 2.0D+00 3.0D+00\n1 2 3\n",
                 "a.xyz:1: found \"0.1D+01 2.0D+00 3.0D+00\", wanted three numbers");
  expect_failure(
      "0\xc2\xb7"
      "5 1\xc2\xb7"
      "5 2\xc2\xb7"
      "5\n1 2 3\n",
      "a.xyz:1");
  expect_failure("1;2;3\n1,5;2;3\n", "a.xyz:2");
  expect_failure("1 2 3\n1,5 2,5 3,5\n", "a.xyz:2: found decimal commas");
  expect_failure("just words\n", "no line with three numbers");
  expect_failure("", "empty");
  expect_failure("1 2 3\r4 5 6\r", "carriage return");
  expect_failure("1 2 3\n1 2 3\r4 5 6\n", "a.xyz:2: found a carriage return");
  expect_failure("1 2 3\n# c\r1 2 3\n", "a.xyz:2: found a carriage return");
  expect_failure("1 2 3\n1 2 3 x\ry\n", "a.xyz:2: found a carriage return");
  expect_failure(std::string("1 2 3\n") + std::string(3 << 20, 'a'), "longer than 1 MiB");
  expect_failure(std::string(3 << 20, '1'), "no line with three numbers");
  expect_failure(
      "\xff\xfe"
      "1",
      "UTF-16");
}

TEST(ReadText, NumbersLinesAcrossBlocks) {
  std::string text = "x y z\n";
  Rows rows;
  Points points;
  for (std::uint64_t i = 2; text.size() < (5u << 20); ++i) {
    if (i % 7 == 0) {
      text += "# comment\n";
      continue;
    }
    text += std::to_string(i) + " 0.5 -1.25" + (i % 3 == 0 ? "\r\n" : "\n");
    rows.push_back(i);
    points.push_back({static_cast<double>(i), 0.5, -1.25});
  }
  const std::shared_ptr<const ByteSource> source = memory_source("a.xyz", text);
  EXPECT_GE((*open_view(source))->block_count(), 4u);
  const auto whole = read_whole(source);
  ASSERT_TRUE(whole.ok()) << whole.error().text();
  EXPECT_EQ(whole->rows, rows);
  EXPECT_EQ(whole->positions, points);
  EXPECT_EQ(whole->header.rows, rows.size());
}

TEST(ReadText, NeverGivesFewerPointsThanDeclaredWhenCutAnywhere) {
  const std::string file = "3\n1.5 2.5 3.5\n# c\n4 5 6\n7 8 9\n";
  for (std::size_t cut = 0; cut < file.size(); ++cut) {
    const auto whole = read_whole("a.pwn", file.substr(0, cut));
    if (whole.ok()) {
      EXPECT_EQ(whole->positions.size(), 3u) << cut;
    }
  }
}

TEST(ReadText, ReadsTheCollectedFiles) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  const std::pair<const char*, std::size_t> expected[] = {{"xyz/crlf_test.txt", 10},
                                                          {"xyz/grid.txt", 32},
                                                          {"xyz/numeric_dim.txt", 5},
                                                          {"xyz/points_agisoft.xyz", 100},
                                                          {"xyz/points_cloudcompare.xyz", 101},
                                                          {"xyz/quoted.txt", 9},
                                                          {"xyz/utm17_1.txt", 10},
                                                          {"xyz/utm17_2.txt", 10},
                                                          {"pts/autzen.pts", 10},
                                                          {"pts/test.pts", 19}};
  for (const auto& [name, points] : expected) {
    const auto whole = read_whole(*store::open_file(data + "/formats/" + name, name));
    ASSERT_TRUE(whole.ok()) << whole.error().text();
    EXPECT_EQ(whole->positions.size(), points) << name;
  }
}

TEST(OpenView, SurvivesEveryBrokenFile) {
  const std::string data = support::data_folder();
  if (data.empty()) GTEST_SKIP() << "no development data";
  const auto names = store::list_files(data + "/broken");
  ASSERT_TRUE(names.ok());
  for (const std::string& name : *names) {
    const auto whole = read_whole(*store::open_file(data + "/broken/" + name, name));
    // The last four are sound where it matters: a wrong count of records nobody needs, a time that is not a number, an
    // odd name.
    const std::set<std::string> sound{"float_inf_point_cloud.ply", "issue_2421.ply",   "missingheader.txt",
                                      "bad_vlr_count.las",         "gps-time-nan.las", "bad_points_1.1.las",
                                      "CubeInvalidUnicode.stl"};
    const bool readable = sound.contains(name);
    EXPECT_EQ(whole.ok(), readable) << name << " " << (whole.ok() ? "" : whole.error().text());
    if (!whole.ok()) {
      EXPECT_EQ(whole.error().where.rfind(name, 0), 0u) << whole.error().text();
    }
    if (name == "float_inf_point_cloud.ply") {
      EXPECT_EQ(whole->not_finite, 3u);
    }
  }
}

TEST(OpenView, TakesTheVerticesOfAMesh) {
  const auto obj = read_whole("a.obj", "v 1 2 3\nv 4 5 6\nv 7 8 10\nf 1 2 3\n");
  ASSERT_TRUE(obj.ok()) << obj.error().text();
  EXPECT_EQ(obj->positions, (std::vector<Vec3>{{1, 2, 3}, {4, 5, 6}, {7, 8, 10}}));
  const auto off = read_whole("a.off", "OFF\n3 1 0\n1 2 3\n4 5 6\n7 8 10\n3 0 1 2\n");
  ASSERT_TRUE(off.ok()) << off.error().text();
  EXPECT_EQ(off->positions, obj->positions);
  EXPECT_NE(read_whole("a.stl", "solid a\nendsolid a\n").error().text().find("no vertex"), std::string::npos);
}

TEST(OpenView, NamesFormatsItDoesNotRead) {
  const std::pair<const char*, std::string> files[] = {
      {"a.laz", "x"},      {"a.las", "LASF" + std::string(100, '\0') + "\x83"},
      {"a.e57", "x"},      {"a.xyz", "glTF"},
      {"a", "PK\x03\x04"}, {"a.vtk", "x"}};
  for (const auto& [name, bytes] : files) {
    const auto whole = read_whole(name, bytes);
    ASSERT_FALSE(whole.ok()) << name;
    EXPECT_EQ(whole.error().code, Code::Unsupported) << whole.error().text();
    EXPECT_NE(whole.error().message.find("is not read by this version"), std::string::npos);
    const bool is_laz = whole.error().message.find("LAZ") != std::string::npos;
    EXPECT_NE(whole.error().message.find(is_laz ? "convert the file to LAS" : "to PLY or XYZ"), std::string::npos);
  }
}

TEST(Probe, TellsPointsFromPosesAndProse) {
  auto kind = [](const char* name, const std::string& bytes) { return probe(*memory_source(name, bytes))->kind; };
  const std::string matrix = "1 0 0 5\n0 1 0 6\n0 0 1 7\n0 0 0 1\n";
  EXPECT_EQ(kind("a.txt", matrix), FileKind::PoseMatrices);
  EXPECT_EQ(kind("a.txt", "0 0 1\n" + matrix + "1 1 2\n" + matrix), FileKind::PoseMatrices);
  EXPECT_EQ(kind("a.txt", matrix + "1 2 3 4\n"), FileKind::Text);
  EXPECT_EQ(kind("a.txt", "1 2 3 4\n1 2 3 4\n1 2 3 4\n1 2 3 4\n"), FileKind::Text);
  EXPECT_EQ(kind("a.txt", "Dear reader,\nthis is prose.\n"), FileKind::Other);
  EXPECT_EQ(kind("a.xyz", "Dear reader,\nthis is prose.\n"), FileKind::Text);
  EXPECT_EQ(kind("a.txt", "x y x\n1 2 3\n"), FileKind::Text);
  EXPECT_EQ(kind("a.txt", ""), FileKind::Text);
  EXPECT_EQ(kind("a.ply", ""), FileKind::Ply);
  EXPECT_EQ(kind("a.bin", std::string("\0\1\2", 3)), FileKind::Other);
  EXPECT_EQ(kind("a.pcd", "VERSION .7\n"), FileKind::Pcd);
  EXPECT_EQ(kind("a.xyz", "# .PCD v0.7\n"), FileKind::Pcd);
  EXPECT_EQ(kind("a.txt", "VERSION 0.7\nFIELDS x y z\n"), FileKind::Pcd);
  EXPECT_EQ(kind("a.ply", "LASF1234"), FileKind::Las);
  EXPECT_EQ(kind("a", "\x89PNG"), FileKind::DepthMap);
  EXPECT_EQ(kind("a.pts", "2\n1 2 3\n1 2 3\n"), FileKind::Pts);
  EXPECT_EQ(kind("a.ptx", "1\n1\n"), FileKind::Ptx);
  const std::string axes = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n", unit = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";
  EXPECT_EQ(kind("a.txt", "1\n1\n" + axes + unit + "1 2 3 0.5\n"), FileKind::Ptx);
  EXPECT_TRUE(
      probe(*memory_source("a.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty int a\nend_header\n"))->has_faces);
}

TEST(OpenView, SurvivesRandomDamage) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string lists =
      "element face 2\nproperty list uchar int v\nelement vertex 3\nproperty list char short l\n" + xyz;
  const std::string seeds[] = {
      "ply\nformat ascii 1.0\nelement vertex 3\n" + xyz + "end_header\n1 2 3\n4 5 6\n7 8 9\n",
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\n" + xyz + "end_header\n" + std::string(36, 'A'),
      "ply\nformat binary_big_endian 1.0\n" + lists + "end_header\n" + std::string("\1aaaa\0", 6) +
          std::string("\0bbbbccccdddd", 13) + std::string("\0bbbbccccdddd", 13) + std::string("\0bbbbccccdddd", 13),
      "ply\nformat ascii 1.0\n" + lists + "end_header\n1 1\n0\n0 1 2 3\n1 9 1 2 3\n0 4 5 6\n",
      "2\n1.5 2.5 3.5 red\n4,5,6\n",
      "\"z\";x;y\n# c\n1;2;3\n4;5;6\r\n",
      "1e5 -2.25 nan\n+7 8 9\n"};
  const std::string pieces[] = {"4294967296",         "-1",    "\n", "\r", "list", "end_header\n", "nan",
                                std::string(1, '\0'), "1e999", ",",  "\""};
  for (std::uint64_t round = 0; round < 4000; ++round) {
    Random random(20240607, round, 1);
    std::string bytes = seeds[round % std::size(seeds)];
    for (std::uint64_t change = 0; change <= random.next() % 4; ++change) {
      const std::size_t at = random.next() % (bytes.size() + 1);
      switch (random.next() % 5) {
        case 0:
          if (at < bytes.size()) bytes[at] = static_cast<char>(random.next());
          break;
        case 1:
          bytes.erase(at, random.next() % 5);
          break;
        case 2:
          bytes.insert(at, pieces[random.next() % std::size(pieces)]);
          break;
        case 3:
          bytes.insert(at, bytes.substr(at, random.next() % 20));
          break;
        default:
          bytes.resize(at);
          break;
      }
      if (bytes.empty()) break;
    }
    const auto whole = read_whole(round % 2 == 0 ? "a.ply" : "a.xyz", bytes);
    if (whole.ok()) {
      EXPECT_EQ(whole->points_read, whole->header.rows) << "round " << round << "\n" << bytes;
    } else {
      EXPECT_TRUE(whole.error().code == Code::BadInput || whole.error().code == Code::Unsupported)
          << "round " << round << whole.error().text();
    }
  }
}

TEST(ReadConf, TakesTheConjugateRotation) {
  const auto views = read_conf(*memory_source("a.conf",
                                              "# views\ncamera 1 2 3\n\nbmesh ./a.ply 1 2 3 0 0 0.7071067811865476 "
                                              "0.7071067811865476\r\nbmesh sub/b.ply 0 0 0 0 0 0 1\n"));
  ASSERT_TRUE(views.ok()) << views.error().text();
  ASSERT_EQ(views->size(), 2u);
  EXPECT_EQ((*views)[0].file, "a.ply");
  const Vec3 p = (*views)[0].pose.apply({1, 0, 0});  // a quarter turn to the right, then the translation
  EXPECT_NEAR(p.x, 1, 1e-12);
  EXPECT_NEAR(p.y, 1, 1e-12);
  EXPECT_NEAR(p.z, 3, 1e-12);
}

TEST(ReadConf, NamesTheLineThatIsWrong) {
  for (const auto& [text, place] : {std::pair{"bmesh a.ply 1 2 3 4 5 6\n", "c:1"},
                                    {"\nfoo\n", "c:2"},
                                    {"bmesh ../a.ply 0 0 0 0 0 0 1\n", "c:1"},
                                    {"bmesh /a.ply 0 0 0 0 0 0 1\n", "c:1"},
                                    {"bmesh a.ply 0 0 0 0 0 0 0\n", "c:1"},
                                    {"camera 1\n", "c"},
                                    {"bmesh a 0 0 0 0 0 0 1\nbmesh a 0 0 0 0 0 0 1\n", "c:2"}}) {
    const auto views = read_conf(*memory_source("c", text));
    ASSERT_FALSE(views.ok()) << text;
    EXPECT_EQ(views.error().where, place) << views.error().text();
  }
}

}  // namespace
}  // namespace scanmill::formats
