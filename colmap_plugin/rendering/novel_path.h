#pragma once

#include "nerf/scene.h"

#include <string>
#include <vector>

#include <Eigen/Core>

namespace structnerf {

// Views that nobody photographed. They have names and no images.

// `num_frames` views along the given ones, from the first to the last: centres
// on straight lines, orientations by spherical interpolation, all with `camera`
// and named "frame_0000", ... Throws std::invalid_argument unless there are at
// least two views and two frames.
std::vector<View> InterpolateViews(const std::vector<View>& views,
                                   const PinholeCamera& camera,
                                   int num_frames);

// A full circle of `radius` (world units) around the centre of `view`, in its
// image plane, always looking at the point in `depth` on its optical axis.
std::vector<View> OrbitView(const View& view,
                            double depth,
                            double radius,
                            int num_frames);

// Poses from a text file, one "NAME QW QX QY QZ TX TY TZ" a line as in COLMAP's
// images.txt (camera from world); empty lines and those that begin with # are
// skipped. Throws std::runtime_error, naming file and line, if one is wrong or
// repeats a name.
std::vector<View> ReadPoses(const std::string& path,
                            const PinholeCamera& camera);

// Median depth of the sparse points that a view observes; of all that lie
// before it if it observes none. Throws std::invalid_argument if there are
// none.
double MedianPointDepth(const Scene& scene, size_t view_idx);

}  // namespace structnerf
