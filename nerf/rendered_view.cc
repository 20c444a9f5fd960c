#include "nerf/rendered_view.h"

namespace structnerf {

void RenderedView::Expose(const Exposure& exposure) {
  for (size_t i = 0; i < color.size(); i += 3) {
    Eigen::Map<Eigen::Vector3f> pixel(&color[i]);
    pixel = exposure.Apply(pixel).cwiseMax(0.0f).cwiseMin(1.0f);
  }
}

}  // namespace structnerf
