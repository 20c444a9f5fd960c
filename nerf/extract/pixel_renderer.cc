#include "nerf/extract/pixel_renderer.h"

namespace structnerf {
namespace {

// Tiles rendered between two looks at whether to abort.
constexpr size_t kTilesPerBatch = 512;

}  // namespace

void RenderPixels(const std::vector<Pixel>& pixels,
                  const ViewGeometry& geometry,
                  const double offset,
                  const Appearance* appearance,
                  RenderEngine* engine,
                  Progress* progress,
                  const PixelVisitor& visit) {
  std::vector<RayTile> tiles;
  std::vector<RayOutputs> outputs;
  for (size_t begin = 0; begin < pixels.size();
       begin += kTilesPerBatch * kMaxTileRays) {
    PauseOrAbort(progress);
    const size_t end =
        std::min(pixels.size(), begin + kTilesPerBatch * kMaxTileRays);
    tiles.assign((end - begin + kMaxTileRays - 1) / kMaxTileRays, RayTile());
    for (size_t i = begin; i < end; ++i) {
      RayTile& tile = tiles[(i - begin) / kMaxTileRays];
      if (appearance != nullptr) {
        tile.has_appearance = true;
        for (size_t k = 0; k < appearance->size(); ++k) {
          tile.appearance[k][tile.num_rays] = (*appearance)[k];
        }
      }
      geometry.SetRay(pixels[i].col + offset,
                      pixels[i].row + offset,
                      tile.num_rays++,
                      &tile);
    }
    engine->Render(tiles, appearance != nullptr, &outputs);
    for (size_t i = begin; i < end; ++i) {
      visit(pixels[i],
            outputs[(i - begin) / kMaxTileRays],
            (i - begin) % kMaxTileRays);
    }
  }
}

}  // namespace structnerf
