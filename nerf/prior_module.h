#pragma once

#include "nerf/progress.h"
#include "nerf/scene.h"

#include <string>

namespace structnerf {

// Asks a TorchScript module of the user for a depth prior of every view (for
// instance a depth completion network, Roessle et al. 2022) and fills in
// View::prior_depth and View::prior_deviation.
//
// The module's forward takes two float tensors of the size of the view's image,
//   image         1 x 3 x height x width, RGB in [0, 1]
//   sparse_depth  1 x 1 x height x width, z-depth of the sparse points that the
//                 view sees, world units; 0 = none. Without those that
//                 RemoveContradictoryPoints would remove
// and returns a tuple of two, depth and its standard deviation, each with
// height x width numbers in world units. Where depth is not positive and finite
// there is no prior; where the deviation is not, it is unknown and taken to be
// the depth itself.
//
// Throws std::runtime_error, naming the file, if it is no such module or what
// it returns has another size; Aborted if told to.
void PredictPriors(const std::string& module_path,
                   Progress* progress,
                   Scene* scene);

}  // namespace structnerf
