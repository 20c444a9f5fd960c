#pragma once

#include "nerf/engine/render_engine.h"
#include "nerf/engine/torch_engine.h"

#include <memory>

namespace structnerf {

// NeRF itself (Mildenhall et al. 2020): a coarse network at evenly spread
// points, a fine one at these and at more where the coarse one stops light
// (nerf/engine/hierarchical_sampling.h), in LibTorch operations. Colour is
// learned by both, the other terms act on what is rendered, which is the fine
// network's. Trained with Adam as NeRF is, with the network's learning rate;
// there is no density cache, and grid options play no role.
//
// FieldParameters::network holds both networks, see InitialMlpParameters.
std::unique_ptr<RenderEngine> MakeTorchMlpEngine(const EngineOptions& options,
                                                 TorchPrecision precision);

}  // namespace structnerf
