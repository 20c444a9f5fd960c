#pragma once

#include <functional>
#include <string>
#include <vector>

#include <colmap/controllers/option_manager.h>
#include <colmap/scene/reconstruction.h>

namespace structnerf {

// Everything that differs between COLMAP 3.10 and 4.1 is behind these
// functions; the rest of the project keeps to what all versions share.

// Sets up COLMAP's logging and image libraries, once per process.
void InitializeColmap(char** argv);

// e.g. "COLMAP 3.10-dev".
std::string ColmapVersionInfo();

// Parses the command line. Prints the help or one line about what is wrong and
// returns false (or, before COLMAP 3.13, exits the process).
bool ParseOptions(int argc, char** argv, colmap::OptionManager* options);

// In the order of the model, which is also that of colmap::mvs::Model.
std::vector<colmap::image_t> RegisteredImageIds(
    const colmap::Reconstruction& reconstruction);

// False for cameras that no pinhole camera can stand for, e.g. spherical ones.
bool IsPerspective(const colmap::Camera& camera);

// True for fisheye lenses without distortion, which COLMAP does not undistort
// (Camera::IsUndistorted), though no pinhole camera can stand for them either.
bool IsIdealFisheye(const colmap::Camera& camera);

// The ray through an image point as (x / z, y / z) in the camera frame, and the
// image point of a ray. False where the camera model has none.
bool RayFromImagePoint(const colmap::Camera& camera,
                       const Eigen::Vector2d& image_point,
                       Eigen::Vector2d* ray);
bool ImagePointFromRay(const colmap::Camera& camera,
                       const Eigen::Vector2d& ray,
                       Eigen::Vector2d* image_point);

// What the head of an image file states.
struct ImageHeader {
  int width = 0;  // pixels
  int height = 0;

  // Whether COLMAP can read it in colour. Before version 4 it fails to for
  // 16-bit grey and floating-point pixels, though it finds features in them.
  bool has_readable_colors = false;
};

// Returns false if COLMAP cannot read the file.
bool ReadImageHeader(const std::string& path, ImageHeader* header);

// Creates COLMAP's dense workspace in the existing folder `output_path`:
// undistorted images, sparse model, stereo folders and configurations. Calls
// `should_stop` before each image and ends early when it returns true. Throws
// std::runtime_error if an image cannot be undistorted.
void CreateUndistortedWorkspace(const colmap::Reconstruction& reconstruction,
                                const std::string& image_path,
                                const std::string& output_path,
                                const std::function<bool()>& should_stop);

}  // namespace structnerf
