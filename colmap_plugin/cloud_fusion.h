#pragma once

#include "colmap_plugin/dense_workspace.h"
#include "nerf/progress.h"
#include "nerf/scene.h"

#include <cstddef>
#include <string>
#include <vector>

#include <colmap/mvs/fusion.h>

namespace structnerf {

// StereoFusion's min_num_pixels; 0 stands for one in ten of the views, at least
// 2 and at most COLMAP's default of 5, or max_num_pixels if that is less. That
// default leaves the clouds of few views nearly empty; pixels of geometric maps
// are confirmed by other views already.
int MinNumPixels(const colmap::mvs::StereoFusionOptions& options,
                 size_t num_views);

// Makes COLMAP's default, which is in every project whether anybody asked for
// it or not, that 0.
void ForgetDefaultMinNumPixels(colmap::mvs::StereoFusionOptions* options);

// Bytes that COLMAP's fusion needs at its peak for these views.
size_t EstimateFusionMemory(const colmap::mvs::StereoFusionOptions& options,
                            const std::vector<PinholeCamera>& cameras);

// Switches on StereoFusion's cache, and then reduces its image size, until it
// needs no more than `max_bytes`. Returns a sentence about what was changed,
// empty if nothing. Throws std::runtime_error if it cannot be made to fit.
std::string FitFusionIntoMemory(const std::vector<PinholeCamera>& cameras,
                                size_t max_bytes,
                                colmap::mvs::StereoFusionOptions* options);

// Fuses the workspace's maps with colmap::mvs::StereoFusion into fused.ply and
// fused.ply.vis; positions far from the origin are written in double precision.
// Returns the number of points, possibly 0. Throws Aborted if told to,
// std::runtime_error if the files cannot be written.
size_t FuseMaps(const DenseWorkspace& workspace,
                MapType map_type,
                const colmap::mvs::StereoFusionOptions& options,
                size_t num_views,
                Progress* progress);

// Why no points were fused, and what to do about it. `has_geometric`: whether
// any pixel's depth was confirmed by other views.
std::string EmptyCloudText(MapType map_type,
                           bool has_geometric,
                           int min_num_pixels);

}  // namespace structnerf
