#include "colmap_plugin/evaluation/depth_evaluation.h"

#include "colmap_plugin/evaluation/pixel_lookup.h"
#include "nerf/util/median.h"

#include <utility>

namespace structnerf {
namespace {

// All pixels of an image that have truth.
struct ImagePixels {
  std::vector<float> truth;
  std::vector<float> prediction;  // model units, 0 = missing
  std::vector<bool> is_textured;
};

ImagePixels CollectPixels(const std::string& name,
                          const std::optional<PredictedDepth>& predicted,
                          TruthViews* truth_views) {
  const cv::Mat1f truth = truth_views->Depth(name);
  const cv::Mat1b textured = truth_views->Textured(name, truth.size());
  const cv::Mat1f prediction =
      predicted ? LookUp(truth_views->Rays(name, truth.size()),
                         predicted->camera,
                         predicted->depth)
                : cv::Mat1f(truth.size(), 0.0f);
  ImagePixels pixels;
  for (int row = 0; row < truth.rows; ++row) {
    for (int col = 0; col < truth.cols; ++col) {
      if (truth(row, col) > 0) {
        pixels.truth.push_back(truth(row, col));
        pixels.prediction.push_back(prediction(row, col));
        pixels.is_textured.push_back(textured(row, col) > 0);
      }
    }
  }
  return pixels;
}

void AppendRatios(const ImagePixels& pixels, std::vector<float>* ratios) {
  for (size_t i = 0; i < pixels.truth.size(); ++i) {
    if (pixels.prediction[i] > 0) {
      ratios->push_back(pixels.truth[i] / pixels.prediction[i]);
    }
  }
}

void AddErrors(const ImagePixels& pixels,
               const double metres_per_unit,
               DepthErrors* all,
               DepthErrors* textured,
               DepthErrors* untextured) {
  const float scale = static_cast<float>(metres_per_unit);
  for (size_t i = 0; i < pixels.truth.size(); ++i) {
    const float prediction = scale * pixels.prediction[i];
    all->Add(pixels.truth[i], prediction);
    (pixels.is_textured[i] ? textured : untextured)
        ->Add(pixels.truth[i], prediction);
  }
}

SplitDepthMetrics Measure(const std::vector<ImagePixels>& images,
                          const std::function<double(size_t)>& scale_of) {
  DepthErrors all;
  DepthErrors textured;
  DepthErrors untextured;
  for (size_t i = 0; i < images.size(); ++i) {
    AddErrors(images[i], scale_of(i), &all, &textured, &untextured);
  }
  return {all.Compute(), textured.Compute(), untextured.Compute()};
}

DepthMetrics MeasureImage(const ImagePixels& pixels, const double scale) {
  return Measure({pixels}, [&](size_t) { return scale; }).all;
}

double TexturedShare(const std::vector<ImagePixels>& images) {
  size_t num_pixels = 0;
  size_t num_textured = 0;
  for (const ImagePixels& pixels : images) {
    num_pixels += pixels.is_textured.size();
    for (const bool is_textured : pixels.is_textured) {
      num_textured += is_textured;
    }
  }
  return num_pixels > 0 ? static_cast<double>(num_textured) / num_pixels : 0.0;
}

}  // namespace

DepthEvaluation EvaluateDepth(const std::vector<std::string>& names,
                              const DepthSource& source,
                              const SceneScale& sfm_scale,
                              TruthViews* truth,
                              StageProgress* progress) {
  DepthEvaluation evaluation;
  evaluation.num_images = names.size();
  std::vector<ImagePixels> images;
  std::vector<float> all_ratios;
  for (const std::string& name : names) {
    const std::optional<PredictedDepth> predicted = source(name);
    images.push_back(CollectPixels(name, predicted, truth));
    ImageDepthMetrics& image = evaluation.images.emplace_back();
    image.name = name;
    image.has_map = predicted.has_value();
    evaluation.num_images_without_map += !image.has_map;
    AppendRatios(images.back(), &all_ratios);
    std::vector<float> ratios;
    AppendRatios(images.back(), &ratios);
    image.metres_per_unit = Median(&ratios);
    progress->Report(images.size(), names.size());
  }
  evaluation.predictions_metres_per_unit = Median(&all_ratios);
  evaluation.textured_share = TexturedShare(images);

  const double predictions_scale = evaluation.predictions_metres_per_unit;
  if (sfm_scale.metres_per_unit > 0) {
    evaluation.in_sfm_scale =
        Measure(images, [&](size_t) { return sfm_scale.metres_per_unit; });
  }
  if (predictions_scale > 0) {
    evaluation.in_predictions_scale =
        Measure(images, [&](size_t) { return predictions_scale; });
    evaluation.in_image_scale = Measure(images, [&](const size_t i) {
      return evaluation.images[i].metres_per_unit;
    });
  }
  const double scene_scale = sfm_scale.metres_per_unit > 0
                                 ? sfm_scale.metres_per_unit
                                 : predictions_scale;
  for (size_t i = 0; i < images.size(); ++i) {
    evaluation.images[i].metrics = MeasureImage(images[i], scene_scale);
  }
  return evaluation;
}

}  // namespace structnerf
