// SPDX-License-Identifier: Apache-2.0
// Limits of nested control groups, read from trees made for the purpose.
#include "fake_work.hpp"
#include "runner/control_group.hpp"

namespace scanmill::runner {
namespace {

class ControlGroup : public RunnerTest {
 protected:
  void process(const std::string& groups, const std::string& mounts) {
    spill(root + "/proc/cgroup", groups);
    spill(root + "/proc/mountinfo", "25 1 8:1 / / rw - ext4 /dev/sda rw\n" + mounts);
  }
  void limit(const std::string& file, const std::string& text) { spill(root + "/sys/fs/cgroup" + file, text + "\n"); }
  std::uint64_t least() const { return group_memory_limit(root + "/proc", root); }

  const std::string v2 = "30 25 0:26 / /sys/fs/cgroup rw,nosuid shared:9 - cgroup2 cgroup2 rw,nsdelegate\n";
  const std::string v1 =
      "34 25 0:32 / /sys/fs/cgroup/cpu rw - cgroup cgroup rw,cpu\n"
      "35 25 0:33 / /sys/fs/cgroup/memory rw - cgroup cgroup rw,memory\n";
};

TEST_F(ControlGroup, OfVersion2CountsWithAllAboveIt) {
  process("0::/system.slice/scanmill.service\n", v2);
  EXPECT_EQ(least(), 0u) << "no file, no limit";
  limit("/system.slice/scanmill.service/memory.max", "max");
  limit("/system.slice/memory.max", "4294967296");
  EXPECT_EQ(least(), 4294967296u);
  limit("/system.slice/scanmill.service/memory.max", "167772160");
  EXPECT_EQ(least(), 167772160u);
  limit("/system.slice/memory.max", "100000000");
  EXPECT_EQ(least(), 100000000u) << "the one above is the tighter one";
  limit("/other.slice/memory.max", "1000");
  EXPECT_EQ(least(), 100000000u) << "it is not in that one";
}

TEST_F(ControlGroup, CountsWhatWasKilledForMemory) {
  const auto kills = [&] { return group_memory_kills(root + "/proc", root); };
  process("0::/a\n", v2);
  EXPECT_FALSE(kills());
  limit("/a/memory.events", "low 0\nhigh 12\nmax 7\noom 3\noom_kill 2");
  EXPECT_EQ(kills(), 2u);
  process("4:memory:/trial\n0::/\n", v1);
  limit("/memory/trial/memory.oom_control", "oom_kill_disable 0\nunder_oom 0\noom_kill 5");
  EXPECT_EQ(kills(), 5u);
}

TEST_F(ControlGroup, OfVersion1CountsWithAllAboveIt) {
  process("7:cpu:/\n4:memory:/trial/inner\n0::/\n", v1);
  limit("/memory/memory.limit_in_bytes", "9223372036854771712");
  limit("/memory/trial/memory.limit_in_bytes", "167772160");
  limit("/memory/trial/inner/memory.limit_in_bytes", "268435456");
  limit("/cpu/memory.limit_in_bytes", "5");
  EXPECT_EQ(least(), 167772160u);
}

TEST_F(ControlGroup, OfBothVersionsAtOnceIsTheLesser) {
  process("4:memory:/a\n0::/b\n", v1 + "41 25 0:38 / /sys/fs/cgroup/unified rw - cgroup2 cgroup2 rw\n");
  limit("/memory/a/memory.limit_in_bytes", "3000");
  limit("/unified/b/memory.max", "2000");
  EXPECT_EQ(least(), 2000u);
}

TEST_F(ControlGroup, OfAContainerIsFoundThroughItsMount) {
  // The host's path, of which only the container's own part is mounted.
  process("0::/docker/4f2a/job\n", "30 25 0:26 /docker/4f2a /sys/fs/cgroup ro - cgroup2 cgroup rw\n");
  limit("/memory.max", "5000");
  limit("/job/memory.max", "4000");
  EXPECT_EQ(least(), 4000u);
  // A path that leads out of what is mounted.
  process("0::/../elsewhere\n", v2);
  EXPECT_EQ(least(), 5000u);
  process("0::/elsewhere\n", "30 25 0:26 /docker/4f2a /sys/fs/cgroup ro - cgroup2 cgroup rw\n");
  EXPECT_EQ(least(), 5000u);
}

TEST_F(ControlGroup, MayHaveBlanksInItsName) {
  process("0::/my group\n", "30 25 0:26 / /sys/fs/cgroup/in\\040here rw - cgroup2 cgroup2 rw\n");
  limit("/in here/my group/memory.max", "7000");
  EXPECT_EQ(least(), 7000u);
}

}  // namespace
}  // namespace scanmill::runner
