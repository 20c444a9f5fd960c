#include "nerf/losses/view_warp.h"

#include "nerf/pixel_transfer.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace structnerf {

ViewWarp MakeViewWarp(const View& view,
                      const View& source,
                      const TrainingViews::Image& image,
                      const TrainingViews::Image& source_image,
                      const double scale) {
  const PixelTransfer transfer(
      view,
      view.camera.Resized(image.width, image.height),
      source,
      source.camera.Resized(source_image.width, source_image.height));
  const Eigen::Vector3d b = transfer.offset * scale;
  ViewWarp warp;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      warp.h[3 * i + j] = static_cast<float>(transfer.matrix(i, j));
    }
    warp.b[i] = static_cast<float>(b(i));
  }
  warp.width = static_cast<float>(source_image.width);
  warp.height = static_cast<float>(source_image.height);
  warp.first_pixel = static_cast<int32_t>(source_image.first_pixel);
  warp.stride = source_image.width;
  return warp;
}

SourceWarps MakeSourceWarps(const Scene& scene,
                            const SceneFrame& frame,
                            const TrainingViews& views,
                            const std::vector<std::vector<int>>& sources) {
  SourceWarps all;
  for (const std::vector<int>& view_sources : sources) {
    all.num_slots =
        std::max(all.num_slots, static_cast<int>(view_sources.size()));
  }
  if (all.num_slots > kMaxSourceSlots) {
    throw std::invalid_argument("at most " + std::to_string(kMaxSourceSlots) +
                                " source views per view");
  }
  all.warps.assign(sources.size() * all.num_slots, ViewWarp{});
  for (size_t v = 0; v < sources.size(); ++v) {
    for (size_t s = 0; s < sources[v].size(); ++s) {
      const int source = sources[v][s];
      all.warps[v * all.num_slots + s] =
          MakeViewWarp(scene.views[v],
                       scene.views[source],
                       views.image(static_cast<int>(v)),
                       views.image(source),
                       frame.scale);
    }
  }
  return all;
}

}  // namespace structnerf
