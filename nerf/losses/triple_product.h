#pragma once

#include <string>

#include <Eigen/Core>

namespace structnerf {

// How four pixels of one planar superpixel are compared.
enum class PlanarForm {
  kInverseDepth,  // nerf/losses/planar_loss.h
  kTripleProduct  // below
};

// Of "inverse_depth" or "triple_product"; throws std::invalid_argument, listing
// them, for any other.
PlanarForm PlanarFormFromName(const std::string& name);

// |AB x AC . AD| of the points depth[i] * directions[i] (paper, eq. 11): six
// times the volume of the tetrahedron, cubic in the unit of depth and zero,
// whatever the depths, for pixels on one line. Writes derivatives by the four
// depths.
//   directions: of the pixels' rays in any frame, of unit z-depth.
float EvaluateTripleProduct(const Eigen::Vector3f directions[4],
                            const float depth[4],
                            float d_depth[4]);

}  // namespace structnerf
