#pragma once

#include "nerf/options.h"

#include <string>

namespace structnerf {

// The methods of the paper's tables, as settings of the same building blocks.
// Returns `options` with what makes the method, and nothing else, changed:
//   "structnerf"  nothing
//   "nerf"        colour only (Mildenhall et al. 2020)
//   "dsnerf"      colour, and the squared error of the sparse points' depth to
//                 the end of the training (Deng et al. 2022), at the paper's
//                 weight if `options` have its losses (quality "paper"), else
//                 at the weight that they have; set sparse_form to "kl" for its
//                 ray-termination form
//   "dense_depth_prior"  colour, the likelihood of the views' depth priors, and
//                 samples around these (Roessle et al. 2022)
//   "nerfing_mvs" colour, on rays that end near the views' depth priors, the
//                 less they agree, the farther away (Wei et al. 2021)
// All but the first end with the field's own depth, without matching of windows
// (StereoOptions). Throws std::invalid_argument, listing them, for any other
// word.
ReconstructionOptions ApplyMethod(const std::string& method,
                                  ReconstructionOptions options);

}  // namespace structnerf
