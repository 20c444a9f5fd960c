#include "colmap_plugin/evaluation/ply_positions.h"

#include "tests/support/temp_dir.h"

#include <fstream>

#include <colmap/util/endian.h>
#include <colmap/util/ply.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::HasSubstr;

class PlyPositionsTest : public testing::Test {
 protected:
  PlyPositionsTest() : path_(temp_dir_ / "cloud.ply") {}

  std::string ErrorOf(const std::string& text) const {
    std::ofstream(path_, std::ios::binary) << text;
    try {
      ReadPlyPositions(path_);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  }

  TempDir temp_dir_;
  const std::string path_;
};

TEST_F(PlyPositionsTest, ReadsWhatColmapWrites) {
  std::vector<colmap::PlyPoint> points(3);
  points[1].x = 1;
  points[1].y = -2.5;
  points[1].z = 3;
  points[2].z = 7;
  colmap::WriteBinaryPlyPoints(path_, points);
  const auto positions = ReadPlyPositions(path_);
  ASSERT_EQ(positions.size(), 3);
  EXPECT_EQ(positions[1], Eigen::Vector3d(1, -2.5, 3));
  EXPECT_EQ(positions[2], Eigen::Vector3d(0, 0, 7));
}

TEST_F(PlyPositionsTest, KeepsDoublePrecisionAmongOtherProperties) {
  std::ofstream file(path_, std::ios::binary);
  file << "ply\nformat binary_little_endian 1.0\ncomment far\n"
          "element vertex 1\nproperty uchar red\nproperty double x\n"
          "property double y\nproperty float nx\nproperty double z\n"
          "element face 1\nproperty list uchar int vertex_indices\n"
          "end_header\n";
  colmap::WriteBinaryLittleEndian<uint8_t>(&file, 7);
  colmap::WriteBinaryLittleEndian<double>(&file, 4500000.125);
  colmap::WriteBinaryLittleEndian<double>(&file, -0.001);
  colmap::WriteBinaryLittleEndian<float>(&file, 1);
  colmap::WriteBinaryLittleEndian<double>(&file, 12345678.0625);
  file << "faces";
  file.close();
  const auto positions = ReadPlyPositions(path_);
  ASSERT_EQ(positions.size(), 1);
  EXPECT_EQ(positions[0], Eigen::Vector3d(4500000.125, -0.001, 12345678.0625));
}

TEST_F(PlyPositionsTest, OneErrorForWhatIsNone) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1000000000\n"
      "property float x\nproperty float y\n";
  EXPECT_THAT(ErrorOf(""), HasSubstr("cloud.ply cannot be read"));
  EXPECT_THAT(ErrorOf("text"), HasSubstr("not a PLY file"));
  EXPECT_THAT(ErrorOf("ply\nformat ascii 1.0\nend_header\n"),
              HasSubstr("binary_little_endian"));
  EXPECT_THAT(ErrorOf(header + "end_header\n"), HasSubstr("x, y and z"));
  EXPECT_THAT(ErrorOf(header + "property int z\nend_header\n"),
              HasSubstr("x, y and z"));
  EXPECT_THAT(ErrorOf(header + "property half z\nend_header\n"),
              HasSubstr("of type half"));
  EXPECT_THAT(ErrorOf(header + "property float z\nend_header\nshort"),
              HasSubstr("shorter than it says"));
}

}  // namespace
}  // namespace structnerf
