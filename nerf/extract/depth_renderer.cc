#include "nerf/extract/depth_renderer.h"

#include "nerf/extract/pixel_renderer.h"
#include "nerf/train/training_views.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace structnerf {
namespace {

// Neighbours whose depths differ by less than this ratio are interpolated.
constexpr float kMaxNeighborRatio = 1.02f;

// Offset of the neighbours of a pixel that are on the lattice, to both sides.
int LatticeOffset(const int i, const int size) {
  return i == size - 1 ? 0 : i % 2;
}

// The rendered pixels around one that was left out.
int Neighbors(const Pixel& pixel,
              const int width,
              const int height,
              size_t* indices) {
  const int col_offset = LatticeOffset(pixel.col, width);
  const int row_offset = LatticeOffset(pixel.row, height);
  const int cols[2] = {pixel.col - col_offset, pixel.col + col_offset};
  const int rows[2] = {pixel.row - row_offset, pixel.row + row_offset};
  int count = 0;
  for (const int row : rows) {
    for (const int col : cols) {
      indices[count++] = static_cast<size_t>(row) * width + col;
    }
  }
  return count;
}

bool IsLatticePixel(const int col,
                    const int row,
                    const int width,
                    const int height) {
  return LatticeOffset(col, width) == 0 && LatticeOffset(row, height) == 0;
}

}  // namespace

DenseMaps RenderDepth(const View& view,
                      const SceneFrame& frame,
                      RenderEngine* engine,
                      Progress* progress) {
  DenseMaps maps;
  maps.width = view.camera.width;
  maps.height = view.camera.height;
  const size_t num_pixels = static_cast<size_t>(maps.width) * maps.height;
  maps.depth.assign(num_pixels, 0.0f);
  maps.relative_std.assign(num_pixels, 0.0f);
  const ViewGeometry geometry(view, view.camera, frame);
  const float world_from_field = static_cast<float>(1.0 / frame.scale);
  const auto render = [&](const std::vector<Pixel>& pixels) {
    RenderPixels(
        pixels,
        geometry,
        /*offset=*/0,
        /*appearance=*/nullptr,
        engine,
        progress,
        [&](const Pixel& pixel, const RayOutputs& outputs, const size_t ray) {
          const size_t index =
              static_cast<size_t>(pixel.row) * maps.width + pixel.col;
          maps.depth[index] = outputs.depth[ray] * world_from_field;
          maps.relative_std[index] =
              std::sqrt(outputs.depth_variance[ray]) / outputs.depth[ray];
        });
  };

  std::vector<Pixel> lattice;
  ForEachPixelInBlocks(maps.width, maps.height, [&](const Pixel& pixel) {
    if (IsLatticePixel(pixel.col, pixel.row, maps.width, maps.height)) {
      lattice.push_back(pixel);
    }
  });
  render(lattice);

  std::vector<Pixel> remaining;
  ForEachPixelInBlocks(maps.width, maps.height, [&](const Pixel& pixel) {
    if (IsLatticePixel(pixel.col, pixel.row, maps.width, maps.height)) {
      return;
    }
    size_t neighbors[4];
    const int count = Neighbors(pixel, maps.width, maps.height, neighbors);
    float nearest = maps.depth[neighbors[0]];
    float farthest = nearest;
    float sum_inverse = 0;
    float sum_std = 0;
    for (int i = 0; i < count; ++i) {
      const float depth = maps.depth[neighbors[i]];
      nearest = std::min(nearest, depth);
      farthest = std::max(farthest, depth);
      sum_inverse += 1.0f / depth;
      sum_std += maps.relative_std[neighbors[i]];
    }
    if (farthest > kMaxNeighborRatio * nearest) {
      remaining.push_back(pixel);
      return;
    }
    const size_t index =
        static_cast<size_t>(pixel.row) * maps.width + pixel.col;
    maps.depth[index] = static_cast<float>(count) / sum_inverse;
    maps.relative_std[index] = sum_std / static_cast<float>(count);
  });
  render(remaining);
  return maps;
}

}  // namespace structnerf
