#include "colmap_plugin/run_expectation.h"

#include "colmap_plugin/input_check.h"
#include "colmap_plugin/option_table.h"
#include "colmap_plugin/run_plan.h"
#include "colmap_plugin/scene_converter.h"
#include "colmap_plugin/text_output.h"
#include "colmap_plugin/time_estimate.h"
#include "nerf/analysis/scene_analysis.h"

#include <algorithm>
#include <exception>
#include <utility>

namespace structnerf {
namespace {

double ExpectedSeconds(const StructNerfOptions& options,
                       const std::vector<PinholeCamera>& cameras) {
  const double seconds = EstimateTime(options, cameras).Total();
  return options.max_minutes > 0 ? std::min(seconds, 60 * options.max_minutes)
                                 : seconds;
}

}  // namespace

RunForecast::RunForecast(
    std::shared_ptr<const colmap::Reconstruction> reconstruction)
    : reconstruction_(std::move(reconstruction)) {
  try {
    CheckModel(*reconstruction_);
    cameras_ = UndistortedCameras(*reconstruction_);
    outline_ = OutlineScene(*reconstruction_);
  } catch (const std::exception& error) {
    error_ = error.what();
  }
}

RunExpectation RunForecast::Expect(const StructNerfOptions& options) const {
  if (!error_.empty()) {
    return {error_, /*is_possible=*/false};
  }
  try {
    CheckOptions(options);
    StructNerfOptions planned = options;
    SceneAnalysis analysis = AnalyzeScene(outline_, options.reconstruction);
    planned.reconstruction = std::move(analysis.options);
    const MemoryPlan plan = PlanMemory(planned, cameras_);
    planned.reconstruction.training.max_image_size = plan.max_image_size;
    RunExpectation expectation;
    expectation.is_possible = true;
    expectation.text =
        std::to_string(cameras_.size()) + " images and " +
        std::to_string(reconstruction_->NumPoints3D()) +
        " points, trained in " +
        std::to_string(options.reconstruction.training.num_steps) +
        " steps on images of " + std::to_string(plan.max_image_size) +
        " pixels. Expected: about " +
        DurationText(ExpectedSeconds(planned, cameras_)) + " and " +
        BytesText(plan.expected) + " of memory (limit " +
        BytesText(plan.limit) + ").";
    if (!plan.note.empty()) {
      expectation.text += " " + plan.note;
    }
    for (const SceneDecision& decision : analysis.decisions) {
      expectation.text += "\n" + decision.Text();
    }
    return expectation;
  } catch (const std::exception& error) {
    return {error.what(), /*is_possible=*/false};
  }
}

}  // namespace structnerf
