#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/scene_frame.h"
#include "nerf/train/training_views.h"
#include "nerf/view_selection.h"

#include <vector>

namespace structnerf {

// Renders the view that Progress wants to watch between training steps, within
// a share of the training time. The engine's state is only read, so what is
// learned does not depend on who watches.
class PreviewRenderer {
 public:
  // Longest side of a preview in pixels.
  static constexpr int kMaxSize = 160;

  // Most of the training time that previews take.
  static constexpr double kMaxTimeShare = 0.04;

  // All but `appearances` (of each view) must outlive this object.
  PreviewRenderer(const Scene& scene,
                  const SceneFrame& frame,
                  const TrainingViews& views,
                  std::vector<Appearance> appearances,
                  RenderEngine* engine);

  // `training_seconds`: time since training began, previews included.
  void RenderIfWanted(double training_seconds, Progress* progress);

  Preview Render(int view_idx) const;

 private:
  const Scene& scene_;
  const SceneFrame& frame_;
  const TrainingViews& views_;
  const std::vector<Appearance> appearances_;
  RenderEngine* const engine_;
  double seconds_ = 0;       // spent so far
  double last_seconds_ = 0;  // by the last preview
};

}  // namespace structnerf
