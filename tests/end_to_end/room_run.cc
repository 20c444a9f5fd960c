#include "tests/end_to_end/room_run.h"

#include "tests/support/synthetic_room_writer.h"

namespace structnerf {

std::unique_ptr<TempDir> RoomRunTest::temp_dir_;
ProgramResult RoomRunTest::dense_result_;

void RoomRunTest::RunOnRoom(const SyntheticRoomOptions& options,
                            const std::vector<std::string>& more_arguments) {
  temp_dir_ = std::make_unique<TempDir>();
  WriteSyntheticRoom(MakeSyntheticRoom(options), Room());
  std::vector<std::string> arguments = {"structnerf_dense",
                                        "--image_path",
                                        Room() + "/images",
                                        "--input_path",
                                        Room() + "/sparse/0",
                                        "--output_path",
                                        Dense(),
                                        "--StructNeRF.quality=low",
                                        "--StructNeRF.num_steps=300"};
  arguments.insert(
      arguments.end(), more_arguments.begin(), more_arguments.end());
  dense_result_ = RunProgram(arguments);
}

void RoomRunTest::TearDownTestSuite() { temp_dir_.reset(); }

void RoomRunTest::SetUp() {
  ASSERT_EQ(dense_result_.exit_code, 0) << dense_result_.error;
}

}  // namespace structnerf
