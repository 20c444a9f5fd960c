// What the field alone leaves wrong is put right by matching windows and by
// planes.

#include "tests/end_to_end/json_files.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/synthetic_room_writer.h"
#include "tests/support/temp_dir.h"

#include <cmath>

#include <colmap/mvs/depth_map.h>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

// Of this room, 65 % of the pixels are within 5 cm without matching, 66 % with
// it but without planes, 73 % with both.
TEST(Matching, WithPlanesPlacesSurfaces) {
  SyntheticRoomOptions options;
  options.num_views = 12;
  options.width = 320;
  options.height = 240;
  const SyntheticRoom room = MakeSyntheticRoom(options);
  const TempDir temp_dir;
  WriteSyntheticRoom(room, temp_dir / "room");
  const ProgramResult result = RunProgram({"structnerf_dense",
                                           "--image_path",
                                           temp_dir / "room/images",
                                           "--input_path",
                                           temp_dir / "room/sparse/0",
                                           "--output_path",
                                           temp_dir / "dense"});
  ASSERT_EQ(result.exit_code, 0) << result.error;

  size_t num_pixels = 0;
  size_t num_right = 0;
  for (size_t i = 0; i < room.images.size(); ++i) {
    const RoomTruth truth = CastTruth(room, i, PixelPoint::kInteger);
    colmap::mvs::DepthMap map;
    map.Read(temp_dir / ("dense/stereo/depth_maps/" + room.images[i].name +
                         ".photometric.bin"));
    for (int row = 0; row < truth.height; ++row) {
      for (int col = 0; col < truth.width; ++col) {
        ++num_pixels;
        num_right += std::abs(map.Get(row, col) -
                              truth.depth[row * truth.width + col]) < 0.05;
      }
    }
  }
  EXPECT_GT(num_right, 0.69 * num_pixels);
  EXPECT_GT(ReadReport(temp_dir / "dense")["maps"]["plane_pixels"],
            0.2 * num_pixels);
}

}  // namespace
}  // namespace structnerf
