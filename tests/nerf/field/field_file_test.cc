#include "nerf/field/field_file.h"

#include "tests/support/temp_dir.h"

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

const Eigen::Vector3f kExtent(1.0f, 0.75f, 0.6f);

FieldOptions SmallOptions() {
  FieldOptions options;
  options.num_levels = 2;
  options.log2_table_size = 10;
  options.min_resolution = 4;
  options.max_resolution = 16;
  options.hidden_width = 16;
  return options;
}

FieldParameters SmallParameters() {
  return InitialParameters(FieldLayout(SmallOptions(), kExtent), 1.5f, 3);
}

std::vector<char> ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file),
          std::istreambuf_iterator<char>()};
}

void WriteBytes(const std::string& path, const std::vector<char>& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

class FieldFileTest : public testing::Test {
 protected:
  FieldFileTest() : path_(folder_ / "a field.bin") {}

  void Write() {
    WriteField(path_, SmallOptions(), kExtent, SmallParameters());
  }

  // What ReadField says; empty if it reads.
  std::string ReadError(const FieldOptions& options = SmallOptions(),
                        const Eigen::Vector3f& extent = kExtent) {
    try {
      ReadField(path_, options, extent);
      return "";
    } catch (const std::runtime_error& error) {
      return error.what();
    }
  }

  void ExpectOnlyThisFile() {
    for (const auto& entry :
         std::filesystem::directory_iterator(folder_.Path())) {
      EXPECT_EQ(entry.path().string(), path_);
    }
  }

  TempDir folder_;
  const std::string path_;
};

TEST_F(FieldFileTest, RoundTripIsExact) {
  Write();
  const FieldParameters expected = SmallParameters();
  const FieldParameters read = ReadField(path_, SmallOptions(), kExtent);
  EXPECT_EQ(read.grid, expected.grid);
  EXPECT_EQ(read.network, expected.network);
  ExpectOnlyThisFile();
}

TEST_F(FieldFileTest, OverwritesAnOlderOne) {
  WriteBytes(path_, std::vector<char>(1000000, 'x'));
  Write();
  EXPECT_EQ(ReadError(), "");
  ExpectOnlyThisFile();
}

TEST_F(FieldFileTest, TruncatedFilesAreRefused) {
  Write();
  const std::vector<char> bytes = ReadBytes(path_);
  for (const size_t size : {size_t{0},
                            size_t{7},
                            size_t{40},
                            bytes.size() / 2,
                            bytes.size() - 8,
                            bytes.size() - 1}) {
    SCOPED_TRACE(size);
    WriteBytes(path_, {bytes.begin(), bytes.begin() + size});
    EXPECT_THAT(ReadError(), HasSubstr(path_));
  }
}

TEST_F(FieldFileTest, BytesAtTheEndAreRefused) {
  Write();
  std::vector<char> bytes = ReadBytes(path_);
  bytes.push_back(0);
  WriteBytes(path_, bytes);
  EXPECT_THAT(ReadError(), HasSubstr(path_));
  EXPECT_THAT(ReadError(), HasSubstr("damaged"));
}

TEST_F(FieldFileTest, EveryFlippedBitIsNoticed) {
  Write();
  std::vector<char> bytes = ReadBytes(path_);
  // Every bit of the head and the checksum, and a sample of the parameters.
  for (size_t i = 0; i < bytes.size();
       i += i < 100 || i + 8 >= bytes.size() ? 1 : 997) {
    for (int bit = 0; bit < 8; bit += 7) {
      bytes[i] ^= static_cast<char>(1 << bit);
      WriteBytes(path_, bytes);
      EXPECT_THAT(ReadError(), HasSubstr(path_))
          << "byte " << i << " bit " << bit;
      bytes[i] ^= static_cast<char>(1 << bit);
    }
  }
  WriteBytes(path_, bytes);
  EXPECT_EQ(ReadError(), "");
}

// Two words of the parameters change places.
TEST_F(FieldFileTest, SwappedWordsAreNoticed) {
  Write();
  std::vector<char> bytes = ReadBytes(path_);
  std::swap_ranges(
      bytes.begin() + 128, bytes.begin() + 136, bytes.begin() + 800);
  WriteBytes(path_, bytes);
  EXPECT_THAT(ReadError(), HasSubstr("damaged"));
}

TEST_F(FieldFileTest, OtherVersionsAreNamed) {
  Write();
  std::vector<char> bytes = ReadBytes(path_);
  bytes[8] = 77;  // after the magic word
  WriteBytes(path_, bytes);
  EXPECT_THAT(ReadError(), HasSubstr(path_));
  EXPECT_THAT(ReadError(), HasSubstr("version 77"));
}

TEST_F(FieldFileTest, OtherOptionsOrBoxesAreRefused) {
  Write();
  const auto expect_refused = [&](const FieldOptions& options,
                                  const Eigen::Vector3f& extent) {
    EXPECT_THAT(ReadError(options, extent), HasSubstr(path_));
    EXPECT_THAT(ReadError(options, extent), HasSubstr("other"));
  };
  FieldOptions options = SmallOptions();
  options.num_levels = 3;
  expect_refused(options, kExtent);
  options = SmallOptions();
  options.log2_table_size = 11;
  expect_refused(options, kExtent);
  options = SmallOptions();
  options.min_resolution = 5;
  expect_refused(options, kExtent);
  options = SmallOptions();
  options.max_resolution = 17;
  expect_refused(options, kExtent);
  options = SmallOptions();
  options.hidden_width = 32;
  expect_refused(options, kExtent);
  options = SmallOptions();
  options.direction_degree = 1;
  expect_refused(options, kExtent);
  expect_refused(SmallOptions(), {1.0f, 0.75f, 0.61f});
  EXPECT_EQ(ReadError(), "");
}

TEST_F(FieldFileTest, OtherFilesAreRefused) {
  WriteBytes(path_, std::vector<char>(5000, 'x'));
  EXPECT_THAT(ReadError(), HasSubstr(path_ + " is not a trained field"));
}

TEST_F(FieldFileTest, MissingFilesAndFolders) {
  EXPECT_THAT(ReadError(), HasSubstr(path_));
  std::filesystem::create_directory(path_);
  EXPECT_THAT(ReadError(), HasSubstr(path_));
}

TEST_F(FieldFileTest, FolderThatDoesNotExist) {
  const std::string path = folder_ / "missing/field.bin";
  try {
    WriteField(path, SmallOptions(), kExtent, SmallParameters());
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(path));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.Path()));
}

TEST_F(FieldFileTest, TargetThatCannotBeReplaced) {
  // A folder that is not empty has the name.
  std::filesystem::create_directories(path_ + "/something");
  try {
    Write();
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(path_));
  }
  ExpectOnlyThisFile();
}

// Every write fails on this device, as on a full disk.
TEST_F(FieldFileTest, FullDisk) {
  if (!std::filesystem::exists("/dev/full")) {
    GTEST_SKIP() << "this system has no /dev/full";
  }
  std::filesystem::create_symlink("/dev/full", path_ + ".partial");
  try {
    Write();
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr(path_));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.Path()));
}

}  // namespace
}  // namespace structnerf
