#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace structnerf::room {

// A number in [0, 1] that looks random but depends on the arguments only.
double HashedUniform(int x, int y, int z, uint32_t seed);

// Smooth noise in [0, 1] with features of about one unit: random values at the
// integer lattice, blended with a cubic.
double ValueNoise(const Eigen::Vector3d& point, uint32_t seed);

// Mean of `num_octaves` noises, each twice as fine and `gain` times as strong
// as the one before. In [0, 1].
double FractalNoise(const Eigen::Vector3d& point,
                    int num_octaves,
                    double gain,
                    uint32_t seed);

}  // namespace structnerf::room
