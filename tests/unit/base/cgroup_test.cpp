// SPDX-License-Identifier: Apache-2.0
// Limits of containers and units, in trees of files as kernels and container engines lay them out.
#include "common/base/cgroup.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

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
  std::optional<CgroupMemory> memory() const { return cgroup_memory(root()); }

 private:
  test::TempFolder folder_;
};

TEST_F(CgroupTest, NothingThereMeansNoLimit) {
  EXPECT_EQ(quota(), 0);
  EXPECT_FALSE(memory().has_value());
}

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
  put("/proc/self/cgroup", "4:cpu,cpuacct:/docker/abc");  // this folder is mounted as the root
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

TEST_F(CgroupTest, MemoryVersion2WithoutALimit) {
  put("/proc/self/cgroup", "0::/user.slice/a.scope");
  put("/sys/fs/cgroup/user.slice/a.scope/memory.max", "max");
  put("/sys/fs/cgroup/user.slice/a.scope/memory.current", "12345");
  EXPECT_FALSE(memory().has_value());
}

TEST_F(CgroupTest, PagesOfFilesCountAsFree) {
  put("/proc/self/cgroup", "0::/");
  put("/sys/fs/cgroup/memory.max", "1000000");
  put("/sys/fs/cgroup/memory.current", "700000");
  put("/sys/fs/cgroup/memory.stat", "anon 1\nactive_file 7\ninactive_file 200000\nslab 5");
  EXPECT_EQ(memory()->limit_bytes, 1'000'000u);
  EXPECT_EQ(memory()->free_bytes, 500'000u);
}

TEST_F(CgroupTest, MemoryTheLeastLimitAndTheLeastLeftOfAllGroupsAbove) {  // MemoryMax= of a slice
  put("/proc/self/cgroup", "0::/tessera.slice/tessera-slave.service");
  put("/sys/fs/cgroup/tessera.slice/tessera-slave.service/memory.max", "1000");
  put("/sys/fs/cgroup/tessera.slice/tessera-slave.service/memory.current", "100");
  put("/sys/fs/cgroup/tessera.slice/memory.max", "4000");
  put("/sys/fs/cgroup/tessera.slice/memory.current", "3700");
  EXPECT_EQ(memory()->limit_bytes, 1000u);
  EXPECT_EQ(memory()->free_bytes, 300u) << "the slice is full of others' memory";
  put("/sys/fs/cgroup/tessera.slice/memory.max", "800");
  EXPECT_EQ(memory()->limit_bytes, 800u);
  EXPECT_EQ(memory()->free_bytes, 0u) << "a limit lowered below what is used";
}

TEST_F(CgroupTest, MemoryVersion1) {
  put("/proc/self/cgroup", "5:memory:/docker/abc\n4:cpu:/b\n0::/");
  put("/sys/fs/cgroup/memory/docker/abc/memory.limit_in_bytes", "9223372036854771712");  // no limit
  put("/sys/fs/cgroup/memory/docker/abc/memory.usage_in_bytes", "500");
  EXPECT_FALSE(memory().has_value());
  put("/sys/fs/cgroup/memory/docker/memory.limit_in_bytes", "2000");
  put("/sys/fs/cgroup/memory/docker/memory.usage_in_bytes", "900");
  put("/sys/fs/cgroup/memory/docker/memory.stat", "inactive_file 1\ntotal_inactive_file 400");
  EXPECT_EQ(memory()->limit_bytes, 2000u);
  EXPECT_EQ(memory()->free_bytes, 1500u);
}

TEST_F(CgroupTest, DamagedMemoryFilesMeanNoLimit) {
  put("/proc/self/cgroup", "0::/");
  for (const char* text : {"", "x", "-1", "12k", "99999999999999999999999"}) {
    put("/sys/fs/cgroup/memory.max", text);
    EXPECT_FALSE(memory().has_value()) << text;
  }
}

}  // namespace
}  // namespace tessera
