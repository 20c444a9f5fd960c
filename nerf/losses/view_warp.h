#pragma once

#include "nerf/scene.h"
#include "nerf/train/training_views.h"

#include <cstdint>

namespace structnerf {

// Map of a view's training image into that of a source view, in single
// precision for gathers: image point p = (x, y, 1) of the view at inverse depth
// rho (field units) lands at h p + rho b, homogeneous, whose third component is
// the depth in the source over that in the view.
struct ViewWarp {
  float h[9];  // row-major
  float b[3];
  float width;  // of the source
  float height;
  int32_t first_pixel;  // of the source, into TrainingViews::Grays()
  int32_t stride;       // pixels per row; 0 marks an empty slot
};

// Least depth in the source, relative to that in the view, of what it sees.
constexpr float kMinDepthRatio = 0.02f;

// `scale`: field units per world unit.
ViewWarp MakeViewWarp(const View& view,
                      const View& source,
                      const TrainingViews::Image& image,
                      const TrainingViews::Image& source_image,
                      double scale);

}  // namespace structnerf
