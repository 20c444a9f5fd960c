#include "tests/support/value_noise.h"

#include <cmath>

namespace structnerf::room {

double HashedUniform(const int x,
                     const int y,
                     const int z,
                     const uint32_t seed) {
  uint32_t hash = seed * 0x9e3779b9u + 0x7f4a7c15u;
  for (const int value : {x, y, z}) {
    hash ^= static_cast<uint32_t>(value);
    hash *= 0x85ebca6bu;
    hash ^= hash >> 15;
    hash *= 0xc2b2ae35u;
    hash ^= hash >> 13;
  }
  return hash * (1.0 / 4294967295.0);
}

double ValueNoise(const Eigen::Vector3d& point, const uint32_t seed) {
  const Eigen::Vector3d cell = point.array().floor();
  const Eigen::Vector3d t = point - cell;
  const Eigen::Vector3d s = t.array().square() * (3.0 - 2.0 * t.array());
  const Eigen::Vector3i base = cell.cast<int>();
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int dx = corner & 1;
    const int dy = (corner >> 1) & 1;
    const int dz = corner >> 2;
    const double weight = (dx ? s.x() : 1 - s.x()) * (dy ? s.y() : 1 - s.y()) *
                          (dz ? s.z() : 1 - s.z());
    sum += weight *
           HashedUniform(base.x() + dx, base.y() + dy, base.z() + dz, seed);
  }
  return sum;
}

double FractalNoise(const Eigen::Vector3d& point,
                    const int num_octaves,
                    const double gain,
                    const uint32_t seed) {
  double sum = 0;
  double total = 0;
  double weight = 1;
  double frequency = 1;
  for (int octave = 0; octave < num_octaves; ++octave) {
    sum += weight * ValueNoise(frequency * point, seed + octave);
    total += weight;
    weight *= gain;
    frequency *= 2;
  }
  return sum / total;
}

}  // namespace structnerf::room
