#include "colmap_plugin/rendering/frame_renderer.h"

#include "colmap_plugin/command_runner.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/rendering/frame_writer.h"
#include "colmap_plugin/rendering/novel_path.h"
#include "colmap_plugin/scene_converter.h"
#include "colmap_plugin/stage_progress.h"
#include "colmap_plugin/staged_folder.h"
#include "colmap_plugin/text_output.h"
#include "colmap_plugin/trained_field.h"
#include "nerf/checkpoint_options.h"
#include "nerf/util/image_name.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <vector>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxFrames = 9999;  // their names have four digits

// The colour scale of depth reaches to so many times the median depth.
constexpr double kFarthestDepth = 2;

// Levels of the 16-bit depth images that a typical depth must have: fewer are
// too coarse, more leave too little for what is farther away.
constexpr double kMinDepthLevels = 100;
constexpr double kMaxDepthLevels = 30000;
constexpr double kGoodDepthLevels = 5000;

class FrameRenderer {
 public:
  FrameRenderer(const RenderOptions& options, RunProgress* progress)
      : options_(options),
        progress_(progress),
        field_(options.workspace_path),
        middle_(Views().size() / 2),
        depth_(MedianPointDepth(field_.Geometry(), middle_)) {}

  size_t Run() {
    CheckDepthScale();
    const std::vector<View> views = ChooseViews();
    WarnOfCamerasOutside(views);
    StagedFolder::UndoCommit(options_.output_path);
    if (HasCheckpoint(StagedFolder::NotesPathOf(options_.output_path))) {
      throw std::runtime_error(
          "The folder " + options_.output_path +
          " holds a run of structnerf_dense that can be gone on with; choose "
          "another folder for the frames, or let the run end first.");
    }
    StagedFolder staged(options_.output_path, /*resume=*/false);
    Render(views, staged.Path());
    staged.Commit();
    return views.size();
  }

 private:
  const std::vector<View>& Views() const { return field_.Geometry().views; }

  void CheckDepthScale() const {
    const double levels = options_.depth_scale * depth_;
    if (levels < kMinDepthLevels || levels > kMaxDepthLevels) {
      const double good_scale =
          std::pow(10, std::round(std::log10(kGoodDepthLevels / depth_)));
      throw std::runtime_error(
          "With --depth_scale " + FormatNumber("%g", options_.depth_scale) +
          " a typical depth of this scene, " + FormatNumber("%g", depth_) +
          " units, is " + FormatNumber("%.3g", levels) +
          " of the 65535 levels of a depth image; pass for instance "
          "--depth_scale " +
          FormatNumber("%g", good_scale) + ".");
    }
  }

  std::vector<View> ChooseViews() const {
    std::vector<View> views;
    if (fs::is_directory(options_.poses_path)) {
      views = ConvertGeometry(ReadModel(options_.poses_path)).views;
    } else if (!options_.poses_path.empty()) {
      views = ReadPoses(options_.poses_path, Views().front().camera);
    } else if (options_.path == "orbit") {
      views = OrbitView(Views()[middle_],
                        depth_,
                        options_.orbit_radius * depth_,
                        options_.num_frames);
    } else {
      std::vector<View> photographed = Views();
      std::sort(photographed.begin(),
                photographed.end(),
                [](const View& a, const View& b) { return a.name < b.name; });
      views = InterpolateViews(
          photographed, photographed.front().camera, options_.num_frames);
    }
    for (View& view : views) {
      CheckName(view.name);
      if (options_.max_image_size > 0) {
        view.camera = view.camera.Reduced(options_.max_image_size);
      }
    }
    return views;
  }

  void CheckName(const std::string& name) const {
    if (!IsSafeImageName(name)) {
      throw std::runtime_error("The name " + Printable(name) + " in " +
                               options_.poses_path +
                               " would be written outside of --output_path.");
    }
  }

  void WarnOfCamerasOutside(const std::vector<View>& views) {
    const auto num_outside =
        std::count_if(views.begin(), views.end(), [&](const View& view) {
          return !field_.Viewer().Contains(view);
        });
    if (num_outside > 0) {
      progress_->Warn(std::to_string(num_outside) + " of " +
                      std::to_string(views.size()) +
                      " cameras are outside of what the field was trained on; "
                      "what they show is not to be relied on.");
    }
  }

  void Render(const std::vector<View>& views, const std::string& folder) {
    FrameOptions frame_options;
    frame_options.depth_scale = options_.depth_scale;
    frame_options.farthest_depth = kFarthestDepth * depth_;
    StageProgress stage("Rendering frames", progress_);
    size_t num_done = 0;
    size_t num_too_deep = 0;
    for (const View& view : views) {
      num_too_deep += WriteFrame(
          field_.Viewer().Render(view, /*scene_view_idx=*/-1, stage.Inner()),
          view.name,
          frame_options,
          folder);
      stage.Report(++num_done, views.size());
    }
    if (num_too_deep > 0) {
      progress_->Warn(std::to_string(num_too_deep) +
                      " pixels are deeper than the " +
                      FormatNumber("%g", LargestDepth(frame_options)) +
                      " units that a depth image holds and have no value "
                      "there; a lower --depth_scale holds more.");
    }
  }

  const RenderOptions options_;
  RunProgress* progress_;
  const TrainedField field_;
  const size_t middle_;  // of the views
  const double depth_;   // median of the points in that view
};

}  // namespace

void RenderOptions::Check() const {
  RequireOptions(
      {{"workspace_path", workspace_path}, {"output_path", output_path}},
      "--workspace_path and --output_path");
  CheckWorkspaceFolder(workspace_path);
  if (path != "input" && path != "orbit") {
    throw std::runtime_error(
        "The option --path must be input or orbit, but is " + path + ".");
  }
  if (num_frames < 2 || num_frames > kMaxFrames) {
    throw std::runtime_error("The option --num_frames must be from 2 to " +
                             std::to_string(kMaxFrames) + ", but is " +
                             std::to_string(num_frames) + ".");
  }
  if (!(orbit_radius > 0) || !(depth_scale > 0) || max_image_size < -1) {
    throw std::runtime_error(
        "The options --orbit_radius and --depth_scale must be positive, "
        "--max_image_size must be positive, or -1 for the photographs' size.");
  }
  for (const char* const folder :
       {kColorFolder, kDepthFolder, kDepthColorFolder, kNormalFolder}) {
    if (!overwrite && fs::exists(fs::path(output_path) / folder)) {
      throw std::runtime_error(
          "The folder " + output_path + " has frames, or other files, in " +
          folder + " already; choose another one or pass --overwrite.");
    }
  }
}

size_t RenderFrames(const RenderOptions& options, RunProgress* progress) {
  options.Check();
  const StageProgress stage("Loading the field", progress);
  return FrameRenderer(options, progress).Run();
}

}  // namespace structnerf
