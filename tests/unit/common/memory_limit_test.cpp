#include "common/memory_limit.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "tests/support/work_folder.h"

namespace lode {
namespace {

constexpr uint64_t kNoLimit = ~uint64_t{0};

/// A folder with control group files as in /proc and /sys.
class ControlGroups : public testing::Test {
 protected:
  void write(const std::string& file, const std::string& text) const {
    std::filesystem::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file) << text << '\n';
  }
  uint64_t limit() const { return controlGroupMemoryBytes(root_.path()); }

  test::WorkFolder root_;
};

TEST_F(ControlGroups, setNoLimitOnASystemWithoutThem) { EXPECT_EQ(limit(), kNoLimit); }

TEST_F(ControlGroups, limitByMemoryMaxInVersion2) {
  write("proc/self/cgroup", "0::/user.slice/job");
  write("sys/fs/cgroup/user.slice/job/memory.max", "536870912");
  EXPECT_EQ(limit(), 536870912u);
}

TEST_F(ControlGroups, limitByALowerMemoryHighInVersion2) {
  write("proc/self/cgroup", "0::/job");
  write("sys/fs/cgroup/job/memory.max", "536870912");
  write("sys/fs/cgroup/job/memory.high", "400000000");
  EXPECT_EQ(limit(), 400000000u);
}

TEST_F(ControlGroups, setNoLimitForTheValueMax) {
  write("proc/self/cgroup", "0::/job");
  write("sys/fs/cgroup/job/memory.max", "max");
  write("sys/fs/cgroup/job/memory.high", "max");
  EXPECT_EQ(limit(), kNoLimit);
}

TEST_F(ControlGroups, limitByTheLeastOfTheirAncestors) {
  write("proc/self/cgroup", "0::/a/b/c");
  write("sys/fs/cgroup/a/b/c/memory.max", "max");
  write("sys/fs/cgroup/a/b/memory.max", "300000000");
  write("sys/fs/cgroup/a/memory.max", "200000000");
  write("sys/fs/cgroup/beside/memory.max", "100000000");
  EXPECT_EQ(limit(), 200000000u);
}

TEST_F(ControlGroups, limitAContainerWithItsOwnTreeByItsRoot) {
  write("proc/self/cgroup", "0::/");
  write("sys/fs/cgroup/memory.max", "123456789");
  EXPECT_EQ(limit(), 123456789u);
}

TEST_F(ControlGroups, limitByTheMemoryControllerInVersion1) {
  write("proc/self/cgroup", "12:cpu,cpuacct:/x\n5:memory:/x\n1:name=systemd:/x\n");
  write("sys/fs/cgroup/memory/x/memory.limit_in_bytes", "1073741824");
  write("sys/fs/cgroup/cpu,cpuacct/x/memory.limit_in_bytes", "1");
  EXPECT_EQ(limit(), 1073741824u);
}

TEST_F(ControlGroups, limitByTheirAncestorsInVersion1) {
  write("proc/self/cgroup", "5:hugetlb,memory:/kubepods/pod");
  write("sys/fs/cgroup/memory/kubepods/pod/memory.limit_in_bytes", "9223372036854771712");
  write("sys/fs/cgroup/memory/kubepods/memory.limit_in_bytes", "700000000");
  EXPECT_EQ(limit(), 700000000u);
}

TEST_F(ControlGroups, limitAContainerWithItsOuterPathByTheVisibleRoot) {
  write("proc/self/cgroup", "5:memory:/docker/0123abcd\n0::/system.slice/docker.service\n");
  write("sys/fs/cgroup/memory/memory.limit_in_bytes", "268435456");
  EXPECT_EQ(limit(), 268435456u);
}

TEST_F(ControlGroups, limitByTheLowerLimitOfBothVersions) {
  write("proc/self/cgroup", "5:memory:/x\n0::/y\n");
  write("sys/fs/cgroup/memory/x/memory.limit_in_bytes", "900000000");
  write("sys/fs/cgroup/unified/y/memory.max", "800000000");
  EXPECT_EQ(limit(), 800000000u);
}

TEST_F(ControlGroups, areNotReadAboveTheVisibleTree) {
  write("proc/self/cgroup", "0::/../../other");
  write("sys/other/memory.max", "1000");
  write("other/memory.max", "1000");
  EXPECT_EQ(limit(), kNoLimit);
}

TEST_F(ControlGroups, setNoLimitForInvalidValues) {
  write("proc/self/cgroup", "0::/job\nno line of a group\n::\n:\n");
  write("sys/fs/cgroup/job/memory.max", "-1");
  write("sys/fs/cgroup/job/memory.high", "12bytes");
  EXPECT_EQ(limit(), kNoLimit);
}

TEST_F(ControlGroups, limitTheMemoryOfThisProcess) {
  write("proc/self/cgroup", "0::/job");
  write("sys/fs/cgroup/job/memory.high", "12345678");
  EXPECT_EQ(memoryLimitBytes(root_.path()), 12345678u);
}

TEST(MemoryLimit, followsTheResourceLimits) {
  const uint64_t before = memoryLimitBytes();
  EXPECT_GT(before, 1u << 20);
  EXPECT_LT(before, uint64_t{1} << 50);
#ifndef LODE_SANITIZED  // sanitizers map more memory than this limit
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    rlimit limit{};
    ASSERT_EQ(getrlimit(resource, &limit), 0);
    const rlimit lower{before - 1, limit.rlim_max};
    ASSERT_EQ(setrlimit(resource, &lower), 0);
    EXPECT_EQ(memoryLimitBytes(), before - 1);
    ASSERT_EQ(setrlimit(resource, &limit), 0);
  }
#endif
}

}  // namespace
}  // namespace lode
