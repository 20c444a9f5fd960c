#pragma once

#include "nerf/progress.h"
#include "nerf/scene.h"

#include <string>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// The pinhole camera that an undistorted camera is.
PinholeCamera ToPinholeCamera(const colmap::Camera& camera);

struct SceneConverterOptions {
  // Folder with the undistorted images.
  std::string image_path;

  // Folder with the masks of the undistorted images; empty = none.
  std::string mask_path;

  // Images are reduced to this many pixels along their longer side.
  int max_image_size = 320;

  // Area in pixels of the full-size image from which on a superpixel is taken
  // for a plane; 0 = do not look for superpixels.
  int planar_min_area = 1000;

  // Images that are read at once; -1 = one on each core.
  int num_threads = -1;
};

// Poses, cameras and points of an undistorted COLMAP model, without pixels. The
// views are in the order of the model's registered images (as in
// colmap::mvs::Model), the points in that of their identifiers. Throws
// std::runtime_error, naming the image, if a camera is not undistorted.
Scene ConvertGeometry(const colmap::Reconstruction& reconstruction);

// The same of a model that need not be undistorted yet, without the points that
// training will remove (RemoveContradictoryPoints).
Scene OutlineScene(const colmap::Reconstruction& reconstruction);

// ConvertGeometry with the photographs, reduced. Throws std::runtime_error,
// naming the image or mask, if one cannot be read or does not have the size of
// its camera; Aborted if told to.
Scene ConvertScene(const colmap::Reconstruction& reconstruction,
                   const SceneConverterOptions& options,
                   Progress* progress);

}  // namespace structnerf
