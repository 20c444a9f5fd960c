#include "nerf/util/array_file.h"

#include "tests/support/temp_dir.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class ArrayFileTest : public testing::Test {
 protected:
  ArrayFileTest() : path_(folder_ / "map.bin") {}

  void ExpectRefused(const std::string& bytes, const size_t num_planes) const {
    std::ofstream(path_, std::ios::binary) << bytes;
    EXPECT_THAT([&]() { ReadArrayFile(path_, num_planes); },
                ThrowsMessage<std::runtime_error>(HasSubstr(path_)))
        << bytes;
  }

  TempDir folder_;
  const std::string path_;
};

// The bytes that COLMAP 3.10 writes for these numbers.
TEST_F(ArrayFileTest, HasTheDocumentedBytes) {
  WriteArrayFile(path_, 2, 1, {1.0f, -0.5f});
  std::ifstream file(path_, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(bytes, std::string("2&1&1&\x00\x00\x80\x3f\x00\x00\x00\xbf", 14));
}

TEST_F(ArrayFileTest, ReadsBackWhatItWrote) {
  std::vector<float> values = {std::numeric_limits<float>::denorm_min(),
                               std::numeric_limits<float>::infinity()};
  values.resize(18, 0.1f);
  WriteArrayFile(path_, 3, 2, values);
  const FloatArray array = ReadArrayFile(path_, 3);
  EXPECT_EQ(array.width, 3);
  EXPECT_EQ(array.height, 2);
  EXPECT_EQ(array.values, values);
  EXPECT_FALSE(std::filesystem::exists(path_ + ".partial"));
}

TEST_F(ArrayFileTest, DamageIsNamed) {
  ExpectRefused("", 1);
  ExpectRefused("1&1&1&abc", 1);
  ExpectRefused("1&1&1&abcde", 1);
  ExpectRefused("1&1&3&abcd", 1);
  ExpectRefused("1&1&1&abcd", 3);
  ExpectRefused("0&1&1&", 1);
  ExpectRefused("-1&-1&1&abcd", 1);
  ExpectRefused("1;1&1&abcd", 1);
  ExpectRefused("99999999&99999999&1&abcd", 1);
  std::filesystem::remove(path_);
  EXPECT_THROW(ReadArrayFile(path_, 1), std::runtime_error);
}

}  // namespace
}  // namespace structnerf
