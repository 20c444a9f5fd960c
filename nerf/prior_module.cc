#include "nerf/prior_module.h"

#include "nerf/scene_guards.h"
#include "nerf/script_module.h"
#include "nerf/train/depth_prior.h"

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

namespace structnerf {
namespace {

torch::Tensor ImageTensor(const RgbImage& image) {
  const torch::Tensor bytes =
      torch::from_blob(const_cast<uint8_t*>(image.data.data()),
                       {1, image.height, image.width, 3},
                       torch::kUInt8);
  return bytes.permute({0, 3, 1, 2}).to(torch::kFloat).div(255).contiguous();
}

// The nearest point where several fall into a pixel.
torch::Tensor SparseDepthTensor(const RgbImage& image,
                                const std::vector<DepthSample>& samples) {
  torch::Tensor sparse_depth =
      torch::zeros({1, 1, image.height, image.width}, torch::kFloat);
  auto pixels = sparse_depth.accessor<float, 4>();
  for (const DepthSample& sample : samples) {
    float& pixel =
        pixels[0][0][static_cast<int>(sample.y)][static_cast<int>(sample.x)];
    const float depth = static_cast<float>(sample.depth);
    pixel = pixel == 0 ? depth : std::min(pixel, depth);
  }
  return sparse_depth;
}

bool IsPositive(const float value) { return value > 0 && std::isfinite(value); }

std::vector<float> Values(const c10::IValue& element, const size_t count) {
  if (!element.isTensor() ||
      element.toTensor().numel() != static_cast<int64_t>(count)) {
    throw std::runtime_error("has another size than the image");
  }
  const torch::Tensor flat =
      element.toTensor().to(torch::kFloat).contiguous().flatten();
  const float* const data = flat.data_ptr<float>();
  return std::vector<float>(data, data + count);
}

void PredictPrior(const std::vector<DepthSample>& samples,
                  torch::jit::Module* module,
                  View* view) {
  const c10::IValue output = module->forward(
      {ImageTensor(view->image), SparseDepthTensor(view->image, samples)});
  if (!output.isTuple() || output.toTuple()->elements().size() != 2) {
    throw std::runtime_error("is not a tuple of depth and deviation");
  }
  const size_t count =
      static_cast<size_t>(view->image.width) * view->image.height;
  view->prior_depth = Values(output.toTuple()->elements()[0], count);
  view->prior_deviation = Values(output.toTuple()->elements()[1], count);
  for (size_t i = 0; i < count; ++i) {
    float& depth = view->prior_depth[i];
    depth = IsPositive(depth) ? depth : 0.0f;
    float& deviation = view->prior_deviation[i];
    deviation = IsPositive(deviation) ? deviation : depth;
  }
}

}  // namespace

void PredictPriors(const std::string& module_path,
                   Progress* progress,
                   Scene* scene) {
  const torch::NoGradGuard no_grad;
  torch::jit::Module module = LoadScriptModule(module_path);
  // Points that training will not believe are none for the module, either.
  std::vector<SparsePoint> points = scene->points;
  RemoveContradictoryPoints(scene);
  const std::vector<std::vector<DepthSample>> samples =
      CollectDepthSamples(*scene);
  scene->points = std::move(points);
  const size_t num_views = scene->views.size();
  for (size_t v = 0; v < num_views; ++v) {
    View& view = scene->views[v];
    try {
      PredictPrior(samples[v], &module, &view);
    } catch (const std::exception& error) {
      throw std::runtime_error("What the module " + module_path +
                               " makes of image " + view.name + " " +
                               FirstLine(error));
    }
    ReportItems("Predicting depth", v + 1, num_views, progress);
  }
}

}  // namespace structnerf
