#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// The positions of a cloud in the binary PLY that stereo_fusion, our dense
// stage and other programs write, in double precision, which geo-referenced
// clouds have and COLMAP's own reader drops. Throws std::runtime_error, naming
// the file, if it is something else, damaged or shorter than it says.
std::vector<Eigen::Vector3d> ReadPlyPositions(const std::string& path);

}  // namespace structnerf
