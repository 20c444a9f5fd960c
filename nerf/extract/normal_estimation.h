#pragma once

#include "nerf/dense_maps.h"
#include "nerf/progress.h"
#include "nerf/scene.h"
#include "nerf/util/thread_pool.h"

namespace structnerf {

// Fills maps->normal from maps->depth: the inverse depth of a plane is affine
// in the image coordinates of a pinhole camera, so a weighted least-squares fit
// of rho = a x + b y + c (normalised coordinates) around each pixel gives the
// normal -(a, b, c), normalised. Neighbours of another depth do not count, so
// edges stay sharp.
void EstimateNormals(const PinholeCamera& camera, DenseMaps* maps);

// The same on all threads. `pool` may be used by nobody else at that time.
// Throws Aborted if told to.
void EstimateNormals(const PinholeCamera& camera,
                     ThreadPool* pool,
                     Progress* progress,
                     DenseMaps* maps);

}  // namespace structnerf
