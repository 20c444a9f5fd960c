#pragma once

#include "nerf/engine/grid_engine.h"

#include <memory>

namespace structnerf {

enum class TorchPrecision { kFloat, kDouble };

// The same engine in plain LibTorch operations with autograd. In double it is
// what the hand-written engines are tested against; it also runs where none of
// them does. Slow on a CPU: a batch of samples streams through memory once per
// operation.
std::unique_ptr<GridEngine> MakeTorchEngine(const EngineOptions& options,
                                            TorchPrecision precision);

}  // namespace structnerf
