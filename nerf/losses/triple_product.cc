#include "nerf/losses/triple_product.h"

#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>

namespace structnerf {

PlanarForm PlanarFormFromName(const std::string& name) {
  if (name == "inverse_depth") {
    return PlanarForm::kInverseDepth;
  } else if (name == "triple_product") {
    return PlanarForm::kTripleProduct;
  }
  throw std::invalid_argument(
      "planar_form must be inverse_depth or triple_product, but is \"" + name +
      "\"");
}

float EvaluateTripleProduct(const Eigen::Vector3f directions[4],
                            const float depth[4],
                            float d_depth[4]) {
  const Eigen::Vector3f a = depth[0] * directions[0];
  const Eigen::Vector3f ab = depth[1] * directions[1] - a;
  const Eigen::Vector3f ac = depth[2] * directions[2] - a;
  const Eigen::Vector3f ad = depth[3] * directions[3] - a;
  const float volume = ab.cross(ac).dot(ad);
  const float sign = std::copysign(1.0f, volume);
  const Eigen::Vector3f by_b = ac.cross(ad);
  const Eigen::Vector3f by_c = ad.cross(ab);
  const Eigen::Vector3f by_d = ab.cross(ac);
  d_depth[0] = -sign * directions[0].dot(by_b + by_c + by_d);
  d_depth[1] = sign * directions[1].dot(by_b);
  d_depth[2] = sign * directions[2].dot(by_c);
  d_depth[3] = sign * directions[3].dot(by_d);
  return std::abs(volume);
}

}  // namespace structnerf
