#include "nerf/engine/render_engine.h"

namespace structnerf {

void AddLosses(const LossValues& losses, LossValues* sum) {
  for (size_t term = 0; term < losses.size(); ++term) {
    (*sum)[term] += losses[term];
  }
}

}  // namespace structnerf
