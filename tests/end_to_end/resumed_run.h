#pragma once

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/end_to_end/run_program.h"
#include "tests/support/temp_dir.h"

#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace structnerf {

// A tiny scene that is undistorted, masked, trained on with many checkpoints
// and fused, and what comes out if nothing happens. On one thread, because the
// order of the points that COLMAP fuses depends on its threads.
class ResumedRunTest : public testing::Test {
 protected:
  ResumedRunTest();

  // The command with its output in that folder. Arguments are --name=value and
  // take the place of those of the same name.
  ProgramOptions Command(const std::vector<std::string>& more_arguments = {},
                         const std::string& output = "dense") const;

  // Runs to the end and fails unless the result is `expected_`.
  ProgramResult ExpectResult(const ProgramOptions& options,
                             const std::string& output = "dense") const;

  // All files of the result but the report, which has times in it.
  std::map<std::string, std::string> ReadResult(
      const std::string& output = "dense") const;

  // Ends a run into dense with SIGTERM when its first checkpoint is there.
  void Terminate() const;

  std::string StagedPath() const;
  std::string CheckpointPath() const;

  TempDir temp_dir_;
  TinyModel model_;

  // Of the run that nobody disturbs, and the seconds that it took.
  std::map<std::string, std::string> expected_;
  double seconds_ = 0;
};

}  // namespace structnerf
