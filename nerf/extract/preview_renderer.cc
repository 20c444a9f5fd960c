#include "nerf/extract/preview_renderer.h"

#include "nerf/extract/view_renderer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace structnerf {
namespace {

uint8_t ByteFromUnit(const float value) {
  return static_cast<uint8_t>(
      std::lround(255.0f * std::min(std::max(value, 0.0f), 1.0f)));
}

}  // namespace

PreviewRenderer::PreviewRenderer(const Scene& scene,
                                 const SceneFrame& frame,
                                 const TrainingViews& views,
                                 std::vector<Appearance> appearances,
                                 RenderEngine* engine)
    : scene_(scene),
      frame_(frame),
      views_(views),
      appearances_(std::move(appearances)),
      engine_(engine) {}

void PreviewRenderer::RenderIfWanted(const double training_seconds,
                                     Progress* progress) {
  const int view_idx = progress->PreviewViewIdx();
  // The next one is taken to cost what the last one did.
  if (view_idx < 0 || view_idx >= static_cast<int>(scene_.views.size()) ||
      seconds_ + last_seconds_ > kMaxTimeShare * training_seconds) {
    return;
  }
  const auto begin = std::chrono::steady_clock::now();
  progress->ShowPreview(Render(view_idx));
  last_seconds_ =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin)
          .count();
  seconds_ += last_seconds_;
}

Preview PreviewRenderer::Render(const int view_idx) const {
  const View& view = scene_.views[view_idx];
  const TrainingViews::Image& image = views_.image(view_idx);
  const double ratio =
      std::min(1.0,
               static_cast<double>(kMaxSize) /
                   static_cast<double>(std::max(image.width, image.height)));
  Preview preview;
  preview.view_idx = view_idx;
  preview.width = std::max(1, static_cast<int>(ratio * image.width));
  preview.height = std::max(1, static_cast<int>(ratio * image.height));
  Progress silent;
  RenderedView rendered =
      RenderPixelCenters(view,
                         view.camera.Resized(preview.width, preview.height),
                         frame_,
                         appearances_[view_idx],
                         engine_,
                         &silent);
  rendered.Expose(view.exposure);
  for (const float channel : rendered.color) {
    preview.color.push_back(ByteFromUnit(channel));
  }
  for (int row = 0; row < preview.height; ++row) {
    for (int col = 0; col < preview.width; ++col) {
      const Eigen::Vector3f color =
          views_.Color(view_idx,
                       col * image.width / preview.width,
                       row * image.height / preview.height);
      for (const float channel : color) {
        preview.photograph.push_back(ByteFromUnit(channel));
      }
    }
  }
  preview.depth = std::move(rendered.depth);
  preview.normal = std::move(rendered.normal);
  return preview;
}

}  // namespace structnerf
