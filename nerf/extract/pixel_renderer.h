#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/progress.h"
#include "nerf/train/training_views.h"
#include "nerf/view_selection.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace structnerf {

struct Pixel {
  int col;
  int row;
};

// Visits pixels in blocks so that the rays of a tile are neighbours and read
// the same part of the grid.
template <typename Visit>
void ForEachPixelInBlocks(const int width, const int height, Visit visit) {
  constexpr int kBlock = 16;
  for (int block_row = 0; block_row < height; block_row += kBlock) {
    for (int block_col = 0; block_col < width; block_col += kBlock) {
      for (int row = block_row; row < std::min(block_row + kBlock, height);
           ++row) {
        for (int col = block_col; col < std::min(block_col + kBlock, width);
             ++col) {
          visit(Pixel{col, row});
        }
      }
    }
  }
}

// Told what the ray of a pixel came to: entry `ray` of `outputs`, field units.
using PixelVisitor = std::function<void(
    const Pixel& pixel, const RayOutputs& outputs, size_t ray)>;

// Renders the rays through the image points (col + offset, row + offset) of
// some pixels. Throws Aborted if told to.
//   appearance: that of colour; null = no colour.
void RenderPixels(const std::vector<Pixel>& pixels,
                  const ViewGeometry& geometry,
                  double offset,
                  const Appearance* appearance,
                  RenderEngine* engine,
                  Progress* progress,
                  const PixelVisitor& visit);

}  // namespace structnerf
