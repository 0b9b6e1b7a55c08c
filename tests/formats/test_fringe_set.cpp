// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "formats/fringe_set.hpp"
#include "formats/probe.hpp"
#include "formats/view_reader.hpp"

namespace scanmill::formats {
namespace {

constexpr const char* kText = R"(scanmill_fringes: 1
stand_off_mm: 200
baseline_mm: -40
gratings:
  - period_mm: 32
    object: [a1.png, a2.png, a3.png]
    plate: [p1.png, p2.png, p3.png]
  - {period_mm: 0.5, object: [b1.png, b2.png, b3.png, b4.png], plate: [q1.png, q2.png, q3.png, q4.png]}
quality: {min_visibility: 0.3}
sha256: {a1.png: 00ff}
)";

Result<FringeSet> read(std::string text) { return read_fringe_set(*memory_source("top.fringes", std::move(text))); }

std::string with(std::string_view was, std::string_view now) {
  std::string text = kText;
  text.replace(text.find(was), was.size(), now);
  return text;
}

TEST(FringeSet, ReadsWhatItWrites) {
  const FringeSet set = read(kText).value();
  EXPECT_EQ(set.optics.stand_off_mm, 200);
  EXPECT_EQ(set.optics.baseline_mm, -40);
  EXPECT_EQ(set.optics.depth_mm, 15);  // as given unless said
  EXPECT_EQ(set.quality.min_visibility, 0.3);
  ASSERT_EQ(set.gratings.size(), 2u);
  EXPECT_EQ(set.gratings[1].object.size(), 4u);
  EXPECT_EQ(set.gratings[0].plate[2], "p3.png");
  EXPECT_EQ(set.sha256, (std::vector<std::pair<std::string, std::string>>{{"a1.png", "00ff"}}));
  EXPECT_EQ(fringe_set_text(read(fringe_set_text(set)).value()), fringe_set_text(set));
  EXPECT_EQ(probe(*memory_source("unnamed", kText)).value().kind, FileKind::Fringes);
}

TEST(FringeSet, NamesEveryProblemWithItsPlace) {
  struct Case {
    const char *was, *now, *wanted;
  };
  for (const Case& c : {Case{"period_mm: 32", "period_mm: 0", "top.fringes:5:5: gratings[0].period_mm"},
                        Case{"a1.png, ", "", "top.fringes:6:13: gratings[0].object: wanted a list of at least 3"},
                        Case{"p1.png", "../p1.png", "gratings[0].plate"}, Case{"plate", "plates", "unknown key"},
                        Case{"scanmill_fringes: 1", "scanmill_fringes: 2", "wanted scanmill_fringes: 1"},
                        Case{"min_visibility: 0.3", "min_visibility: 3", "quality.min_visibility"},
                        Case{"stand_off_mm: 200", "stand_off_mm: near", "stand_off_mm"}}) {
    const auto set = read(with(c.was, c.now));
    ASSERT_FALSE(set.ok()) << c.now;
    EXPECT_EQ(set.error().code, Code::BadInput);
    EXPECT_NE(set.error().text().find(c.wanted), std::string::npos) << set.error().text();
  }
}

TEST(FringeSet, SurvivesBeingCutAnywhere) {
  const std::string text = kText;
  for (std::size_t end = 0; end < text.size(); ++end) {
    const auto set = read(text.substr(0, end));
    if (set.ok()) {
      EXPECT_FALSE(set->gratings.empty());
    }
  }
}

TEST(FringeSet, NamesAPictureThatIsNotThere) {
  OpenOptions options;
  options.open_beside = [](const std::string& name) -> Result<std::shared_ptr<const ByteSource>> {
    return fail(Code::BadInput, "found no file", name);
  };
  const auto view = open_view(memory_source("top.fringes", kText), options);
  ASSERT_FALSE(view.ok());
  EXPECT_EQ(view.error().where, "top.fringes: a1.png");
  EXPECT_EQ(open_view(memory_source("top.fringes", kText)).error().code, Code::Unsupported);
}

}  // namespace
}  // namespace scanmill::formats
