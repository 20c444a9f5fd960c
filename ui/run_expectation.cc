#include "ui/run_expectation.h"

#include "colmap_plugin/input_check.h"
#include "colmap_plugin/option_table.h"
#include "colmap_plugin/run_plan.h"
#include "colmap_plugin/terminal_progress.h"
#include "colmap_plugin/time_estimate.h"

#include <algorithm>
#include <cstdio>
#include <exception>

namespace structnerf {
namespace {

std::string GbText(const size_t num_bytes) {
  char text[32];
  snprintf(text, sizeof(text), "%.1f GB", num_bytes / 1024.0 / 1024.0 / 1024.0);
  return text;
}

double ExpectedSeconds(const StructNerfOptions& options,
                       const std::vector<PinholeCamera>& cameras) {
  const double seconds = EstimateTime(options, cameras).Total();
  return options.max_minutes > 0 ? std::min(seconds, 60 * options.max_minutes)
                                 : seconds;
}

}  // namespace

RunExpectation ExpectRun(const StructNerfOptions& options,
                         const colmap::Reconstruction& reconstruction) {
  try {
    CheckModel(reconstruction);
    CheckOptions(options);
    const auto cameras = UndistortedCameras(reconstruction);
    const MemoryPlan plan = PlanMemory(options, cameras);
    StructNerfOptions planned = options;
    planned.reconstruction.training.max_image_size = plan.max_image_size;
    RunExpectation expectation;
    expectation.is_possible = true;
    expectation.text =
        std::to_string(cameras.size()) + " images and " +
        std::to_string(reconstruction.NumPoints3D()) + " points, trained in " +
        std::to_string(options.reconstruction.training.num_steps) +
        " steps on images of " + std::to_string(plan.max_image_size) +
        " pixels. Expected: about " +
        DurationText(ExpectedSeconds(planned, cameras)) + " and " +
        GbText(plan.expected) + " of memory (limit " + GbText(plan.limit) +
        ").";
    if (!plan.note.empty()) {
      expectation.text += " " + plan.note;
    }
    return expectation;
  } catch (const std::exception& error) {
    return {error.what(), /*is_possible=*/false};
  }
}

}  // namespace structnerf
