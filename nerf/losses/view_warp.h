#pragma once

#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/train/training_views.h"

#include <cstdint>
#include <vector>

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

// Most source views per view.
constexpr int kMaxSourceSlots = 32;

// The warps of every view into its sources.
struct SourceWarps {
  int num_slots = 0;  // per view; a view may leave the last ones empty
  std::vector<ViewWarp> warps;  // views x num_slots
};

// `sources`: source views of each view, indices into the views. Throws
// std::invalid_argument if a view has more than kMaxSourceSlots.
SourceWarps MakeSourceWarps(const Scene& scene,
                            const SceneFrame& frame,
                            const TrainingViews& views,
                            const std::vector<std::vector<int>>& sources);

}  // namespace structnerf
