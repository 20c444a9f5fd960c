#include "nerf/extract/view_renderer.h"

#include "nerf/extract/normal_estimation.h"
#include "nerf/extract/pixel_renderer.h"

#include <utility>

namespace structnerf {

RenderedView RenderPixelCenters(const View& view,
                                const PinholeCamera& camera,
                                const SceneFrame& frame,
                                const Appearance& appearance,
                                RenderEngine* engine,
                                Progress* progress) {
  DenseMaps maps;
  maps.width = camera.width;
  maps.height = camera.height;
  const size_t num_pixels = static_cast<size_t>(maps.width) * maps.height;
  maps.depth.resize(num_pixels);
  std::vector<float> color(3 * num_pixels);

  std::vector<Pixel> pixels;
  pixels.reserve(num_pixels);
  ForEachPixelInBlocks(maps.width, maps.height, [&](const Pixel& pixel) {
    pixels.push_back(pixel);
  });
  const float world_from_field = static_cast<float>(1.0 / frame.scale);
  RenderPixels(
      pixels,
      ViewGeometry(view, camera, frame),
      /*offset=*/0.5,
      &appearance,
      engine,
      progress,
      [&](const Pixel& pixel, const RayOutputs& outputs, const size_t ray) {
        const size_t index =
            static_cast<size_t>(pixel.row) * maps.width + pixel.col;
        maps.depth[index] = outputs.depth[ray] * world_from_field;
        for (int channel = 0; channel < 3; ++channel) {
          color[3 * index + channel] = outputs.color[channel][ray];
        }
      });

  // Seen from this camera, the centre of the first pixel is at (0, 0).
  PinholeCamera centered = camera;
  centered.cx -= 0.5;
  centered.cy -= 0.5;
  EstimateNormals(centered, &maps);
  return {maps.width,
          maps.height,
          std::move(color),
          std::move(maps.depth),
          std::move(maps.normal)};
}

}  // namespace structnerf
