#include "nerf/planes/dominant_direction.h"

#include "nerf/util/random.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

constexpr int kNumCandidates = 300;
constexpr size_t kMaxNormals = 10000;

// Normals count within this angle, in degrees; the direction is then refined
// with narrower ones, since the tails are not symmetric.
constexpr float kAngle = 8;
constexpr float kRefinedAngles[] = {8, 8, 6, 4, 3, 3};

float CosineOfDegrees(const float angle) {
  return std::cos(angle * static_cast<float>(M_PI) / 180.0f);
}

}  // namespace

DominantDirection FindDominantDirection(
    const std::vector<Eigen::Vector3f>& normals) {
  DominantDirection result;
  if (normals.empty()) {
    return result;
  }
  const size_t step = std::max<size_t>(1, normals.size() / kMaxNormals);
  const auto count_near = [&](const Eigen::Vector3f& direction,
                              const float angle,
                              Eigen::Vector3f* sum) {
    const float min_cosine = CosineOfDegrees(angle);
    size_t count = 0;
    sum->setZero();
    for (size_t i = 0; i < normals.size(); i += step) {
      const float cosine = direction.dot(normals[i]);
      if (std::abs(cosine) > min_cosine) {
        ++count;
        *sum += std::copysign(1.0f, cosine) * normals[i];
      }
    }
    return count;
  };
  Random random(normals.size());
  Eigen::Vector3f sum;
  size_t best_count = 0;
  for (int i = 0; i < kNumCandidates; ++i) {
    const Eigen::Vector3f& candidate =
        normals[random.NextBelow(static_cast<uint32_t>(normals.size()))];
    const size_t count = count_near(candidate, kAngle, &sum);
    if (count > best_count) {
      best_count = count;
      result.direction = candidate;
    }
  }
  for (const float angle : kRefinedAngles) {
    count_near(result.direction, angle, &sum);
    if (sum.norm() > 0) {
      result.direction = sum.normalized();
    }
  }
  best_count = count_near(result.direction, kAngle, &sum);
  result.share = static_cast<float>(best_count) /
                 static_cast<float>((normals.size() + step - 1) / step);
  return result;
}

}  // namespace structnerf
