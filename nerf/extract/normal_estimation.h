#pragma once

#include "nerf/dense_maps.h"
#include "nerf/scene.h"
#include "nerf/util/thread_pool.h"

namespace structnerf {

// Fills maps->normal from maps->depth: the inverse depth of a plane is affine
// in the image coordinates of a pinhole camera, so a weighted least-squares fit
// of rho = a x + b y + c (normalised coordinates) around each pixel gives the
// normal -(a, b, c), normalised. Neighbours of another depth do not count, so
// edges stay sharp. `pool` may be used by nobody else at that time; null = the
// calling thread does it alone.
void EstimateNormals(const PinholeCamera& camera,
                     ThreadPool* pool,
                     DenseMaps* maps);

}  // namespace structnerf
