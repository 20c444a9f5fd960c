#include "nerf/methods.h"

#include <stdexcept>

namespace structnerf {
namespace {

// What the paper gives its baselines (section on their implementation).
constexpr double kDsNerfSparseWeight = 0.1;
constexpr double kDensePriorWeight = 0.008;

// Neither hints of structure nor depth, nor stereo at the end.
void KeepOnlyColor(ReconstructionOptions* options) {
  options->loss.patch_weight = 0;
  options->loss.planar_weight = 0;
  options->loss.sparse_weight = 0;
  options->loss.prior_weight = 0;
  options->loss.far_weight = 0;
  options->loss.match_weight = 0;
  options->stereo.num_iterations = 0;
}

}  // namespace

ReconstructionOptions ApplyMethod(const std::string& method,
                                  ReconstructionOptions options) {
  const LossOptions loss = options.loss;
  if (method == "nerf") {
    KeepOnlyColor(&options);
  } else if (method == "dsnerf") {
    KeepOnlyColor(&options);
    options.loss.sparse_weight = loss.sparse_form == "squared"
                                     ? kDsNerfSparseWeight
                                     : loss.sparse_weight;
    options.loss.sparse_form = "squared";
    options.loss.sparse_fraction = 1;
  } else if (method == "dense_depth_prior") {
    KeepOnlyColor(&options);
    options.loss.dense_prior_weight = kDensePriorWeight;
    options.sampling.guide_by_prior = true;
  } else if (method == "nerfing_mvs") {
    KeepOnlyColor(&options);
    options.sampling.bound_by_prior = true;
  } else if (method != "structnerf") {
    throw std::invalid_argument(
        "method must be structnerf, nerf, dsnerf, dense_depth_prior or "
        "nerfing_mvs, but is \"" +
        method + "\"");
  }
  return options;
}

}  // namespace structnerf
