// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "formats/linuxcnc.hpp"
#include "formats/poses.hpp"

namespace scanmill::formats {
namespace {

Result<CncMachine> ini(const std::string& text) { return read_linuxcnc(*memory_source("m.ini", text)); }

TEST(ReadLinuxcnc, ReadsOldAndNewSections) {
  const auto old = ini(
      "[EMC]\nMACHINE = old # one\n[TRAJ]\nCOORDINATES = X Y\nLINEAR_UNITS = "
      "inch\n[AXIS_0]\nTYPE=LINEAR\nMIN_LIMIT=-1\n"
      "MAX_LIMIT = 2\nMAX_VELOCITY = 3\nMAX_ACCELERATION = 4\nBACKLASH = 0.01\nSCALE = -1000\nHOME = 0.5\n[AXIS_Y]\n"
      "MIN_LIMIT = 0\nMAX_LIMIT = 5\n");
  ASSERT_TRUE(old.ok()) << old.error().text();
  EXPECT_EQ(old->name, "old");
  ASSERT_EQ(old->joints.size(), 2u);
  const CncJoint& x = old->joints[0];
  EXPECT_EQ(x.letter, 'X');
  EXPECT_DOUBLE_EQ(*x.low, -25.4);
  EXPECT_DOUBLE_EQ(*x.high, 50.8);
  EXPECT_DOUBLE_EQ(*x.velocity, 76.2);
  EXPECT_DOUBLE_EQ(*x.acceleration, 101.6);
  EXPECT_DOUBLE_EQ(x.home, 12.7);
  EXPECT_DOUBLE_EQ(*x.counts_per_unit, 1000 / 25.4);
  EXPECT_EQ(old->notes.size(), 1u) << "the sign of SCALE";
  EXPECT_DOUBLE_EQ(*old->joints[1].high, 127);
  const auto newer = ini(
      "[KINS]\nKINEMATICS = trivkins coordinates=xzb kinstype=BOTH\n[AXIS_X]\nMIN_LIMIT = 1\nMAX_LIMIT = 9\n[JOINT_0]\n"
      "MAX_VELOCITY = 7\n[JOINT_1]\n[JOINT_2]\nMIN_LIMIT = -90\nMAX_LIMIT = 0\nENCODER_SCALE = 40\nSCALE = 9\n");
  ASSERT_TRUE(newer.ok()) << newer.error().text();
  ASSERT_EQ(newer->joints.size(), 3u);
  EXPECT_EQ(*newer->joints[0].low, 1) << "limits of the axis where the joint gives none";
  EXPECT_EQ(newer->joints[2].letter, 'B');
  EXPECT_TRUE(newer->joints[2].angular);
  EXPECT_EQ(*newer->joints[2].counts_per_unit, 40);
}

TEST(ReadLinuxcnc, SaysWhatIsWrongAndWhere) {
  const auto error = [](const std::string& text) {
    const auto machine = ini(text);
    return machine.ok() ? std::string("no error") : machine.error().text();
  };
  EXPECT_EQ(error(""), "m.ini: found no section [JOINT_0] or [AXIS_X]; wanted a LinuxCNC INI file");
  EXPECT_EQ(error("[A]\nno equals\n"), "m.ini:2: found \"no equals\", wanted [SECTION] or KEY = VALUE");
  EXPECT_EQ(error("[JOINT_0]\nMAX_LIMIT = ten\n"), "m.ini:2: MAX_LIMIT: found \"ten\", wanted a number");
  EXPECT_EQ(error("[JOINT_0]\nMIN_LIMIT = 3\nMAX_LIMIT = 1\n"), "m.ini:2: MIN_LIMIT lies above MAX_LIMIT");
  EXPECT_EQ(error("[TRAJ]\nLINEAR_UNITS = ell\n"), "m.ini:2: LINEAR_UNITS: found \"ell\", wanted mm or inch");
  for (std::size_t size = 0; size < 60; ++size)
    EXPECT_NO_FATAL_FAILURE(
        (void)ini(std::string("[JOINT_0]\nMIN_LIMIT = 3\nMAX_LIMIT = 1\n[KINS]\nX=\xff\x00y", 50).substr(0, size)));
}

TEST(Read3dtkPose, TurnsLeftHandedAnglesIntoARigidPose) {
  // Only about z: in the left-handed frame x goes to y; negating z changes nothing of that.
  const auto z = read_3dtk_pose(*memory_source("s.pose", "1 2 3\n0 0 90\n"));
  ASSERT_TRUE(z.ok()) << z.error().text();
  EXPECT_EQ(z->apply({1, 0, 0}), (Vec3{1, 3, -3}));
  // About x by 90: y goes to z there, to -z here.
  const auto x = read_3dtk_pose(*memory_source("s.pose", "0 0 0 90 0 0"));
  ASSERT_TRUE(x.ok());
  EXPECT_EQ(x->apply({0, 1, 0}), (Vec3{0, 0, -1}));
  EXPECT_EQ(read_3dtk_pose(*memory_source("s.pose", "1 2 3\n0 x 0\n")).error().text(),
            "s.pose:2: found \"x\", wanted x y z and three angles in degrees");
  EXPECT_EQ(read_3dtk_pose(*memory_source("s.pose", "1 2 3\n")).error().text(),
            "s.pose: found 3 numbers, wanted x y z and three angles in degrees");
  EXPECT_FALSE(read_3dtk_pose(*memory_source("s.pose", "1 2 3 4 5 6 7")).ok());
}

}  // namespace
}  // namespace scanmill::formats
