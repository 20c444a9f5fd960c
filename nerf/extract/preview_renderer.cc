#include "nerf/extract/preview_renderer.h"

#include "nerf/dense_maps.h"
#include "nerf/extract/normal_estimation.h"

#include <algorithm>
#include <chrono>
#include <cmath>

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
                                 RenderEngine* engine)
    : scene_(scene), frame_(frame), views_(views), engine_(engine) {}

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
  const size_t num_pixels = static_cast<size_t>(preview.width) * preview.height;
  PinholeCamera camera = view.camera.Resized(preview.width, preview.height);
  const ViewGeometry geometry(view, camera, frame_);

  std::vector<RayTile> tiles((num_pixels + kMaxTileRays - 1) / kMaxTileRays);
  for (size_t i = 0; i < num_pixels; ++i) {
    RayTile& tile = tiles[i / kMaxTileRays];
    geometry.SetRay(i % preview.width + 0.5,
                    i / preview.width + 0.5,
                    tile.num_rays++,
                    &tile);
  }
  std::vector<RayOutputs> outputs;
  engine_->Render(tiles, /*with_color=*/true, &outputs);

  DenseMaps maps;
  maps.width = preview.width;
  maps.height = preview.height;
  maps.depth.resize(num_pixels);
  preview.photograph.resize(3 * num_pixels);
  preview.color.resize(3 * num_pixels);
  const float world_from_field = static_cast<float>(1.0 / frame_.scale);
  for (size_t i = 0; i < num_pixels; ++i) {
    const RayOutputs& output = outputs[i / kMaxTileRays];
    const size_t ray = i % kMaxTileRays;
    maps.depth[i] = output.depth[ray] * world_from_field;
    const Eigen::Vector3f color = views_.Color(
        view_idx,
        static_cast<int>(i % preview.width * image.width / preview.width),
        static_cast<int>(i / preview.width * image.height / preview.height));
    for (int c = 0; c < 3; ++c) {
      preview.photograph[3 * i + c] = ByteFromUnit(color[c]);
      preview.color[3 * i + c] = ByteFromUnit(output.color[c][ray]);
    }
  }
  // Maps belong to the rays through (col, row), these pixels to their centres.
  camera.cx -= 0.5;
  camera.cy -= 0.5;
  EstimateNormals(camera, &maps);
  preview.depth = std::move(maps.depth);
  preview.normal = std::move(maps.normal);
  return preview;
}

}  // namespace structnerf
