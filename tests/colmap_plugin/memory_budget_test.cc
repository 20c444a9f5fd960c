#include "colmap_plugin/memory_budget.h"

#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

constexpr size_t kNoLimit = std::numeric_limits<size_t>::max();

// Where the two versions of control groups have their limit.
constexpr char kVersion1[] = "memory/memory.limit_in_bytes";
constexpr char kVersion2[] = "memory.max";

class ControlGroupLimitTest : public testing::Test {
 protected:
  ControlGroupLimitTest() {
    std::filesystem::create_directory(temp_dir_ / "memory");
  }

  void Write(const std::string& name, const std::string& text) {
    const std::string path = temp_dir_ / name;
    std::filesystem::create_directories(
        std::filesystem::path(path).parent_path());
    std::ofstream(path) << text;
  }

  size_t Limit() const {
    return ControlGroupLimit(temp_dir_.Path().string(), temp_dir_ / "groups");
  }

  const TempDir temp_dir_;
};

TEST_F(ControlGroupLimitTest, ReadsBothVersions) {
  Write(kVersion2, "1073741824\n");
  EXPECT_EQ(Limit(), size_t{1} << 30);
  // With both, the smaller counts.
  Write(kVersion1, "536870912\n");
  EXPECT_EQ(Limit(), size_t{1} << 29);
  std::filesystem::remove(temp_dir_ / kVersion2);
  EXPECT_EQ(Limit(), size_t{1} << 29);
}

TEST_F(ControlGroupLimitTest, GroupsAreBoundByThoseAroundThem) {
  Write("groups", "0::/system.slice/job.scope\n");
  Write("system.slice/job.scope/memory.max", "4096\n");
  Write("other.slice/memory.max", "16\n");
  EXPECT_EQ(Limit(), 4096u);
  Write("system.slice/memory.max", "2048\n");
  EXPECT_EQ(Limit(), 2048u);
  Write("memory.max", "8192\n");
  EXPECT_EQ(Limit(), 2048u);
}

TEST_F(ControlGroupLimitTest, Version1HasAHierarchyForMemory) {
  Write("groups", "5:cpu,cpuacct:/fast\n4:hugetlb,memory:/slurm/job_1\n0::/\n");
  Write("memory/slurm/job_1/memory.limit_in_bytes", "4096\n");
  Write("memory/fast/memory.limit_in_bytes", "16\n");
  EXPECT_EQ(Limit(), 4096u);
  Write("memory/slurm/memory.limit_in_bytes", "2048\n");
  EXPECT_EQ(Limit(), 2048u);
  // A container that does not see its own group sees the outermost.
  Write("groups", "garbage\n4:memory:/docker/1\n");
  EXPECT_EQ(Limit(), kNoLimit);
  Write(kVersion1, "1024\n");
  EXPECT_EQ(Limit(), 1024u);
}

TEST_F(ControlGroupLimitTest, MayNotBeSet) {
  EXPECT_EQ(Limit(), kNoLimit);
  Write(kVersion2, "max\n");
  EXPECT_EQ(Limit(), kNoLimit);
  // What version 1 says instead; it is beyond any memory.
  Write(kVersion1, "9223372036854771712\n");
  EXPECT_EQ(Limit(), 9223372036854771712u);
}

TEST_F(ControlGroupLimitTest, GarbageIsNoLimit) {
  for (const std::string text :
       {"", "\n", "0", "-5", "12apples", "1e9", "99999999999999999999999"}) {
    Write(kVersion1, "max");
    Write(kVersion2, text);
    EXPECT_EQ(Limit(), kNoLimit) << text;
  }
}

TEST(MemoryLimit, IsWhatIsAskedForOrAShareOfWhatThereIs) {
  EXPECT_EQ(MemoryLimit(0.5), size_t{1} << 29);
  EXPECT_EQ(MemoryLimit(-1), AvailableMemory() / 4 * 3);
}

}  // namespace
}  // namespace structnerf
