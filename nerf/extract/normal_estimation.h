#pragma once

#include "nerf/dense_maps.h"
#include "nerf/scene.h"

namespace structnerf {

// Fills maps->normal from maps->depth: the inverse depth of a plane is affine
// in the image coordinates of a pinhole camera, so a weighted least-squares fit
// of rho = a x + b y + c (normalised coordinates) around each pixel gives the
// normal -(a, b, c), normalised. Neighbours of another depth do not count, so
// edges stay sharp.
void EstimateNormals(const PinholeCamera& camera, DenseMaps* maps);

}  // namespace structnerf
