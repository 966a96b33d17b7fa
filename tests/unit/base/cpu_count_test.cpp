// Limits of containers, in trees of files as kernels and container engines lay them out; lists of
// processors as people write them.
#include "common/base/cpu_count.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "common/base/cgroup_quota.h"
#include "common/base/limits.h"
#include "tests/support/temp_folder.h"

namespace tessera {
namespace {

class CgroupTest : public ::testing::Test {
 protected:
  void put(const std::string& path, const std::string& text) {
    const std::filesystem::path file = root() + path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text << "\n";
  }
  std::string root() const { return folder_.path(); }
  double quota() const { return cgroup_cpu_quota(root()); }

 private:
  test::TempFolder folder_;
};

TEST_F(CgroupTest, NothingThereMeansNoLimit) { EXPECT_EQ(quota(), 0); }

TEST_F(CgroupTest, Version2InsideAContainersNamespace) {  // docker run --cpus 1.5
  put("/proc/self/cgroup", "0::/");
  put("/sys/fs/cgroup/cpu.max", "150000 100000");
  EXPECT_DOUBLE_EQ(quota(), 1.5);
}

TEST_F(CgroupTest, Version2WithoutALimit) {
  put("/proc/self/cgroup", "0::/user.slice/a.scope");
  put("/sys/fs/cgroup/user.slice/a.scope/cpu.max", "max 100000");
  EXPECT_EQ(quota(), 0);
}

TEST_F(CgroupTest, Version2TheLeastOfAllGroupsAboveCounts) {  // systemd: CPUQuota= of a slice
  put("/proc/self/cgroup", "0::/tessera.slice/tessera-slave.service");
  put("/sys/fs/cgroup/tessera.slice/tessera-slave.service/cpu.max", "800000 100000");
  put("/sys/fs/cgroup/tessera.slice/cpu.max", "200000 100000");
  EXPECT_DOUBLE_EQ(quota(), 2);
}

TEST_F(CgroupTest, Version1WithItsControllerMountedTwice) {
  put("/proc/self/cgroup", "5:memory:/a\n4:cpu,cpuacct:/docker/abc\n1:name=systemd:/x");
  put("/sys/fs/cgroup/cpu,cpuacct/docker/abc/cpu.cfs_quota_us", "250000");
  put("/sys/fs/cgroup/cpu,cpuacct/docker/abc/cpu.cfs_period_us", "100000");
  put("/sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "-1");
  put("/sys/fs/cgroup/cpu,cpuacct/cpu.cfs_period_us", "100000");
  EXPECT_DOUBLE_EQ(quota(), 2.5);
}

TEST_F(CgroupTest, Version1InAContainerThatSeesTheHostsPath) {
  put("/proc/self/cgroup", "4:cpu,cpuacct:/docker/abc");  // not there: mounted as the root
  put("/sys/fs/cgroup/cpu/cpu.cfs_quota_us", "50000");
  put("/sys/fs/cgroup/cpu/cpu.cfs_period_us", "100000");
  EXPECT_DOUBLE_EQ(quota(), 0.5);
}

TEST_F(CgroupTest, HybridTreesTakeTheLeast) {
  put("/proc/self/cgroup", "4:cpu:/b\n0::/a");
  put("/sys/fs/cgroup/unified/a/cpu.max", "300000 100000");
  put("/sys/fs/cgroup/cpu/b/cpu.cfs_quota_us", "100000");
  put("/sys/fs/cgroup/cpu/b/cpu.cfs_period_us", "100000");
  EXPECT_DOUBLE_EQ(quota(), 1);
}

TEST_F(CgroupTest, DamagedFilesMeanNoLimit) {
  put("/proc/self/cgroup", "::::\n0\n0:\n0::\n0::/../../etc\n4:cpu:relative");
  for (const char* text :
       {"", "x y", "100000", "0 100000", "100000 0", "-1 -1", "nan 1", "1e999 1"}) {
    put("/sys/fs/cgroup/cpu.max", text);
    EXPECT_EQ(quota(), 0) << text;
  }
}

TEST(CpuCount, RoundsQuotasUpAndKeepsToItsBounds) {
  EXPECT_EQ(cpu_count_of(8, 0), 8);
  EXPECT_EQ(cpu_count_of(8, 1.5), 2);
  EXPECT_EQ(cpu_count_of(8, 0.1), 1);
  EXPECT_EQ(cpu_count_of(2, 64), 2);
  EXPECT_EQ(cpu_count_of(2, 1e300), 2);
  EXPECT_EQ(cpu_count_of(0, 0), 1);
  EXPECT_EQ(cpu_count_of(10'000, 0), kWorkersMax);
}

TEST(CpuCount, ReadsHowManyAndWhich) {
  const std::vector<int> allowed{0, 1, 2, 3, 8, 9};
  EXPECT_EQ(*parse_cpus("2", allowed), (std::vector<int>{0, 1}));
  EXPECT_EQ(*parse_cpus("6", allowed), allowed);
  EXPECT_EQ(*parse_cpus("2-2", allowed), std::vector<int>{2});
  EXPECT_EQ(*parse_cpus("8,1-3", allowed), (std::vector<int>{1, 2, 3, 8}));
  for (const char* wrong : {"", "0", "7", "-1", "a", "1-", "3-1", "1,,2", "0-9", "1-99999999999"})
    EXPECT_FALSE(parse_cpus(wrong, allowed).is_ok()) << wrong;
}

TEST(CpuCount, ThisProcessMayUseAtLeastOne) {
  EXPECT_GE(available_cpu_count(), 1);
  EXPECT_LE(available_cpu_count(), static_cast<int>(allowed_cpus().size()));
}

}  // namespace
}  // namespace tessera
