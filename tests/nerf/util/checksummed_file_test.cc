#include "nerf/util/checksummed_file.h"

#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr FileFormat kFormat = {
    {'A', 'B', 'C', 'D', 'E', 'F', 'G', 'H'}, /*version=*/3, "thing"};
constexpr FileFormat kNewerFormat = {
    {'A', 'B', 'C', 'D', 'E', 'F', 'G', 'H'}, /*version=*/4, "thing"};
constexpr FileFormat kOtherFormat = {
    {'A', 'B', 'C', 'D', 'E', 'F', 'G', 'I'}, /*version=*/3, "thing"};

class ChecksummedFileTest : public testing::Test {
 protected:
  ChecksummedFileTest() : path_(folder_ / "thing.bin") {}

  void Write(const std::vector<int>& values,
             const std::string& path_of_older = "") {
    ChecksummedFileWriter writer(kFormat, path_);
    writer.WriteArray(values);
    writer.Commit(path_of_older);
  }

  std::vector<int> Read(const std::string& path,
                        const FileFormat& format = kFormat) {
    ChecksummedFileReader reader(format, path);
    const auto values = reader.ReadArray<std::vector<int>>();
    EXPECT_EQ(reader.NumBytesLeft(), 0u);
    return values;
  }

  TempDir folder_;
  const std::string path_;
};

TEST(Checksum, DoesNotDependOnThePortions) {
  std::vector<char> bytes;
  for (int i = 0; i < 100; ++i) {
    bytes.push_back(static_cast<char>(7 * i + i * i));
  }
  Checksum whole;
  whole.Add(bytes.data(), bytes.size());
  for (const size_t portion : {1, 3, 8, 9, 64}) {
    Checksum checksum;
    for (size_t begin = 0; begin < bytes.size(); begin += portion) {
      checksum.Add(bytes.data() + begin,
                   std::min(portion, bytes.size() - begin));
      checksum.Add(nullptr, 0);
    }
    EXPECT_EQ(checksum.Value(), whole.Value()) << portion;
  }
  whole.Add(bytes.data(), 1);
  Checksum other;
  other.Add(bytes.data(), bytes.size());
  EXPECT_NE(whole.Value(), other.Value());
}

TEST_F(ChecksummedFileTest, ReadsWhatWasWritten) {
  // Sizes around the block that is checked at a time.
  for (const int size : {0, 1, 100, 16380, 16381, 16382, 16384, 50000}) {
    std::vector<int> values(size);
    for (int i = 0; i < size; ++i) {
      values[i] = 31 * i;
    }
    Write(values);
    EXPECT_EQ(Read(path_), values);
  }
}

TEST_F(ChecksummedFileTest, NothingHasTheNameBeforeItIsComplete) {
  {
    ChecksummedFileWriter writer(kFormat, path_);
    writer.WriteValue(1);
    EXPECT_FALSE(fs::exists(path_));
  }
  EXPECT_TRUE(fs::is_empty(folder_.Path()));
}

TEST_F(ChecksummedFileTest, KeepsTheOlderFile) {
  const std::string older = folder_ / "older.bin";
  Write({1}, older);
  EXPECT_FALSE(fs::exists(older));
  Write({2}, older);
  Write({3}, older);
  EXPECT_EQ(Read(path_), std::vector<int>{3});
  EXPECT_EQ(Read(older), std::vector<int>{2});
}

TEST_F(ChecksummedFileTest, AnyDamageIsNoticed) {
  Write({1, 2, 3});
  const auto size = fs::file_size(path_);
  std::ifstream file(path_, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  const auto expect_refused = [&](const std::string& changed) {
    std::ofstream(path_, std::ios::binary) << changed;
    EXPECT_THAT([&]() { Read(path_); },
                ThrowsMessage<std::runtime_error>(HasSubstr(path_)));
  };
  for (size_t i = 0; i < size; ++i) {
    expect_refused(bytes.substr(0, i));
    for (int bit = 0; bit < 8; ++bit) {
      std::string changed = bytes;
      changed[i] ^= static_cast<char>(1 << bit);
      expect_refused(changed);
    }
  }
  expect_refused(bytes + '\0');
}

TEST_F(ChecksummedFileTest, OtherFormats) {
  Write({1});
  EXPECT_THAT([&]() { Read(path_, kOtherFormat); },
              ThrowsMessage<std::runtime_error>(HasSubstr("not a thing")));
  EXPECT_THAT([&]() { Read(path_, kNewerFormat); },
              ThrowsMessage<OtherFormatVersion>(HasSubstr("version 3")));
  EXPECT_THAT([&]() { Read(folder_ / "none"); },
              ThrowsMessage<std::runtime_error>(HasSubstr("none")));
}

// The checksum is right, the numbers in it are not.
TEST_F(ChecksummedFileTest, LengthsAreNotTrusted) {
  {
    ChecksummedFileWriter writer(kFormat, path_);
    writer.WriteValue(uint64_t{1} << 62);
    writer.WriteValue(1);
    writer.Commit();
  }
  EXPECT_THROW(Read(path_), std::runtime_error);
  ChecksummedFileReader reader(kFormat, path_);
  char bytes[13];
  EXPECT_THROW(reader.Read(bytes, 13), std::runtime_error);
}

// Every write fails on this device, as on a full disk.
TEST_F(ChecksummedFileTest, FullDisk) {
  if (!fs::exists("/dev/full")) {
    GTEST_SKIP() << "this system has no /dev/full";
  }
  Write({1});
  fs::create_symlink("/dev/full", path_ + ".partial");
  EXPECT_THAT([&]() { Write({2}); },
              ThrowsMessage<std::runtime_error>(HasSubstr("full")));
  EXPECT_FALSE(fs::exists(path_ + ".partial"));
  EXPECT_EQ(Read(path_), std::vector<int>{1});
}

}  // namespace
}  // namespace structnerf
