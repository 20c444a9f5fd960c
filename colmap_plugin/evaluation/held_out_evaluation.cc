#include "colmap_plugin/evaluation/held_out_evaluation.h"

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/evaluation/image_metrics.h"
#include "colmap_plugin/evaluation/model_alignment.h"
#include "colmap_plugin/image_file.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/scene_converter.h"
#include "nerf/perceptual_module.h"

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <unordered_set>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// Models that fit worse are of another scene, or too poor to judge images by.
constexpr double kMaxAlignmentError = 0.05;

colmap::Camera PinholeCameraOf(const PinholeCamera& camera) {
  colmap::Camera pinhole =
      colmap::Camera::CreateFromModelName(colmap::kInvalidCameraId,
                                          "PINHOLE",
                                          camera.fx,
                                          camera.width,
                                          camera.height);
  pinhole.params = {camera.fx, camera.fy, camera.cx, camera.cy};
  return pinhole;
}

// Interleaved RGB in [0, 1].
std::vector<float> ReadPhotograph(const std::string& path, const View& view) {
  const cv::Mat3b image = ReadColorImage(path);
  if (image.cols != view.camera.width || image.rows != view.camera.height) {
    throw std::runtime_error(
        "The photograph " + path +
        (image.empty() ? " cannot be read." : " has not its camera's size."));
  }
  std::vector<float> pixels;
  pixels.reserve(3 * image.total());
  for (const cv::Vec3b& bgr : image) {
    for (int channel = 2; channel >= 0; --channel) {
      pixels.push_back(bgr[channel] / 255.0f);
    }
  }
  return pixels;
}

// The same memory.
cv::Mat3f ColorMat(const int width,
                   const int height,
                   std::vector<float>* pixels) {
  return cv::Mat3f(height, width, reinterpret_cast<cv::Vec3f*>(pixels->data()));
}

// A view to be rendered; `scene_view_idx` as FieldViewer::Render takes it.
struct HeldOutView {
  View view;
  int scene_view_idx = -1;
};

std::vector<HeldOutView> ViewsHeldOutOfTraining(const TrainedField& field) {
  std::vector<HeldOutView> views;
  for (const int view_idx : field.HeldOutViewIdxs()) {
    views.push_back({field.Geometry().views[view_idx], view_idx});
  }
  return views;
}

// The views of the test workspace that the evaluated one does not have, moved
// into its world.
std::vector<HeldOutView> UnseenViews(const std::string& test_workspace_path,
                                     const std::vector<View>& seen,
                                     HeldOutEvaluation* evaluation) {
  const DenseWorkspace workspace(test_workspace_path);
  const Scene test = ConvertGeometry(ReadModel(workspace.SparsePath()));
  const ModelAlignment alignment = AlignModels(test.views, seen);
  evaluation->num_common_views = alignment.num_common_views;
  evaluation->alignment_error = alignment.relative_error;
  if (alignment.relative_error > kMaxAlignmentError) {
    throw std::runtime_error(
        "The model of --test_workspace_path " + test_workspace_path +
        " does not fit to that of the evaluated workspace: the camera "
        "positions "
        "differ by " +
        std::to_string(100 * alignment.relative_error) +
        " % of their spread; register the held-out images to that model, for "
        "instance with image_registrator.");
  }
  std::unordered_set<std::string> seen_names;
  for (const View& view : seen) {
    seen_names.insert(view.name);
  }
  std::vector<HeldOutView> unseen;
  for (const View& view : test.views) {
    if (seen_names.count(view.name) == 0) {
      unseen.push_back({alignment.Apply(view), -1});
    }
  }
  if (unseen.empty()) {
    throw std::runtime_error(
        "The workspace of --test_workspace_path " + test_workspace_path +
        " has no image that the evaluated workspace has not.");
  }
  return unseen;
}

template <typename Value>
double MeanOver(const std::vector<HeldOutImage>& images, Value value) {
  double sum = 0;
  for (const HeldOutImage& image : images) {
    sum += value(image);
  }
  return images.empty() ? 0.0 : sum / images.size();
}

}  // namespace

double HeldOutEvaluation::MeanPsnr() const {
  return MeanOver(images, [](const HeldOutImage& image) { return image.psnr; });
}

double HeldOutEvaluation::MeanSsim() const {
  return MeanOver(images, [](const HeldOutImage& image) { return image.ssim; });
}

std::optional<double> HeldOutEvaluation::MeanLpips() const {
  if (images.empty() || !images.front().lpips) {
    return std::nullopt;
  }
  return MeanOver(images,
                  [](const HeldOutImage& image) { return *image.lpips; });
}

HeldOutEvaluation EvaluateHeldOut(const std::string& workspace_path,
                                  const TrainedField& field,
                                  const HeldOutOptions& options,
                                  StageProgress* progress) {
  HeldOutEvaluation evaluation;
  std::unique_ptr<PerceptualModule> perceptual_module;
  if (!options.lpips_path.empty()) {
    perceptual_module = std::make_unique<PerceptualModule>(options.lpips_path);
  }
  const bool is_strict = !options.test_workspace_path.empty();
  evaluation.image_path =
      DenseWorkspace(is_strict ? options.test_workspace_path : workspace_path)
          .ImagesPath();
  const std::vector<HeldOutView> views =
      is_strict ? UnseenViews(options.test_workspace_path,
                              field.Geometry().views,
                              &evaluation)
                : ViewsHeldOutOfTraining(field);
  for (const auto& [view, scene_view_idx] : views) {
    std::vector<float> photograph = ReadPhotograph(
        (fs::path(evaluation.image_path) / view.name).string(), view);
    RenderedView rendered =
        field.Viewer().Render(view, scene_view_idx, progress->Inner());
    rendered.Expose(view.exposure);
    const cv::Mat3f reference =
        ColorMat(rendered.width, rendered.height, &photograph);
    const cv::Mat3f color =
        ColorMat(rendered.width, rendered.height, &rendered.color);
    HeldOutImage& image = evaluation.images.emplace_back();
    image.name = view.name;
    image.psnr = Psnr(color, reference);
    image.ssim = Ssim(color, reference);
    if (perceptual_module != nullptr) {
      image.lpips = perceptual_module->Measure(
          rendered.width, rendered.height, rendered.color, photograph);
    }
    evaluation.depth[view.name] = {
        PinholeCameraOf(view.camera),
        cv::Mat1f(rendered.height, rendered.width, rendered.depth.data())
            .clone()};
    progress->Report(evaluation.images.size(), views.size());
  }
  return evaluation;
}

}  // namespace structnerf
