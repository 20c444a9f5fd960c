#pragma once

#include "tests/end_to_end/run_program.h"
#include "tests/support/synthetic_room.h"
#include "tests/support/temp_dir.h"

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {

// A short run on a small room, whose workspace all tests of a suite look at.
class RoomRunTest : public testing::Test {
 protected:
  // To be called from SetUpTestSuite. Arguments are added to the command.
  static void RunOnRoom(const SyntheticRoomOptions& options,
                        const std::vector<std::string>& more_arguments = {});

  static void TearDownTestSuite();

  void SetUp() override;

  static std::string Room() { return *temp_dir_ / "room"; }
  static std::string Dense() { return *temp_dir_ / "dense"; }

  static std::unique_ptr<TempDir> temp_dir_;

 private:
  static ProgramResult dense_result_;
};

}  // namespace structnerf
