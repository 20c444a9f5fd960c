#include "colmap_plugin/stock_colmap.h"

#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

class StockColmapTest : public testing::Test {
 protected:
  StockColmapTest() {
    own_path_ = MakeProgram("own/colmap-structnerf");
    fs::create_directories(temp_dir_ / "alias");
    fs::create_symlink(own_path_, temp_dir_ / "alias/colmap");
  }

  std::string MakeProgram(const std::string& name) {
    const std::string path = MakeFile(name);
    fs::permissions(path, fs::perms::owner_all);
    return path;
  }

  std::string MakeFile(const std::string& name) {
    const std::string path = temp_dir_ / name;
    fs::create_directories(fs::path(path).parent_path());
    std::ofstream(path) << "#!/bin/sh\n";
    return path;
  }

  std::string Find(const char* environment_path,
                   const std::string& configured_path,
                   const std::string& search_path) {
    return FindStockColmap(
        environment_path, configured_path, search_path, own_path_);
  }

  TempDir temp_dir_;
  std::string own_path_;
};

TEST_F(StockColmapTest, EnvironmentComesFirstThenConfiguredThenPath) {
  const std::string environment = MakeProgram("environment/my-colmap");
  const std::string configured = MakeProgram("configured/colmap");
  const std::string searched = MakeProgram("searched/colmap");
  EXPECT_EQ(Find(environment.c_str(), configured, temp_dir_ / "searched"),
            environment);
  EXPECT_EQ(Find(nullptr, configured, temp_dir_ / "searched"), configured);
  EXPECT_EQ(Find("", configured, temp_dir_ / "searched"), configured);
  EXPECT_EQ(Find(nullptr, temp_dir_ / "none", temp_dir_ / "searched"),
            searched);
}

TEST_F(StockColmapTest, PathSkipsOurselvesAndFilesThatAreNoPrograms) {
  const std::string stock = MakeProgram("stock/colmap");
  MakeFile("text/colmap");
  fs::create_directories(temp_dir_ / "folder/colmap");
  EXPECT_EQ(Find(nullptr,
                 temp_dir_ / "alias/colmap",
                 temp_dir_ / "none" + ":" + temp_dir_ / "alias" + ":" +
                     temp_dir_ / "text" + ":" + temp_dir_ / "folder" + ":" +
                     temp_dir_ / "stock"),
            stock);
}

TEST_F(StockColmapTest, WrongEnvironmentIsNotIgnored) {
  const std::string configured = MakeProgram("configured/colmap");
  for (const std::string& path :
       {temp_dir_ / "none", temp_dir_ / "alias/colmap", MakeFile("text")}) {
    try {
      Find(path.c_str(), configured, "");
      FAIL() << path;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr(path));
      EXPECT_THAT(error.what(), HasSubstr("COLMAP_STRUCTNERF_STOCK_COLMAP"));
    }
  }
}

TEST_F(StockColmapTest, SaysWhatToDoWhenThereIsNone) {
  try {
    Find(nullptr, temp_dir_ / "none", temp_dir_ / "alias");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("COLMAP_STRUCTNERF_STOCK_COLMAP"));
  }
}

}  // namespace
}  // namespace structnerf
