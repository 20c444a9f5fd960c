#include "tests/support/temp_dir.h"

#include <fstream>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(TempDir, IsUniqueAndLeavesNothingBehind) {
  std::filesystem::path path;
  {
    const TempDir first;
    const TempDir second;
    EXPECT_NE(first.Path(), second.Path());
    path = first.Path();
    EXPECT_TRUE(std::filesystem::is_empty(path));
    std::filesystem::create_directory(first / "folder");
    std::ofstream(first / "folder/file") << "text";
    EXPECT_TRUE(std::filesystem::exists(path / "folder" / "file"));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace structnerf
