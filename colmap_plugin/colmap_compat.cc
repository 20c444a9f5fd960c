#include "colmap_plugin/colmap_compat.h"

#include <fstream>
#include <optional>
#include <stdexcept>
#include <unordered_set>

#include <colmap/image/undistortion.h>
#include <colmap/util/logging.h>
#include <colmap/util/version.h>

#if STRUCTNERF_COLMAP_VERSION >= 40000
#include <colmap/controllers/undistorters.h>
#include <colmap/sensor/bitmap.h>
#include <colmap/util/oiio_utils.h>
#else
#include <FreeImage.h>
#endif

namespace structnerf {
namespace {

// COLMAP only logs images that it cannot undistort, and leaves them out of the
// list of images to fuse.
void CheckUndistorted(const colmap::Reconstruction& reconstruction,
                      const std::string& output_path) {
  std::ifstream file(output_path + "/stereo/fusion.cfg");
  std::unordered_set<std::string> names;
  for (std::string name; std::getline(file, name);) {
    names.insert(name);
  }
  for (const colmap::image_t image_id : RegisteredImageIds(reconstruction)) {
    const std::string& name = reconstruction.Image(image_id).Name();
    if (names.count(name) == 0) {
      throw std::runtime_error(
          "The image " + name +
          " could not be undistorted; it is damaged or the disk is full.");
    }
  }
}

}  // namespace

void InitializeColmap(char** argv) {
  colmap::InitializeGlog(argv);
#if STRUCTNERF_COLMAP_VERSION >= 40000
  colmap::EnsureOpenImageIOInitialized();
#endif
}

std::string ColmapVersionInfo() { return colmap::GetVersionInfo(); }

bool ParseOptions(const int argc, char** argv, colmap::OptionManager* options) {
#if STRUCTNERF_COLMAP_VERSION >= 31300
  return options->Parse(argc, argv);
#else
  options->Parse(argc, argv);
  return true;
#endif
}

std::vector<colmap::image_t> RegisteredImageIds(
    const colmap::Reconstruction& reconstruction) {
  // A vector, a set or a temporary, depending on the version.
  const auto& image_ids = reconstruction.RegImageIds();
  return {image_ids.begin(), image_ids.end()};
}

bool IsPerspective([[maybe_unused]] const colmap::Camera& camera) {
#if STRUCTNERF_COLMAP_VERSION >= 40100
  return !camera.IsSpherical();
#else
  return true;
#endif
}

bool IsIdealFisheye(const colmap::Camera& camera) {
  return camera.IsUndistorted() &&
         camera.ModelName().find("FISHEYE") != std::string::npos;
}

bool RayFromImagePoint(const colmap::Camera& camera,
                       const Eigen::Vector2d& image_point,
                       Eigen::Vector2d* ray) {
#if STRUCTNERF_COLMAP_VERSION >= 31200
  const std::optional<Eigen::Vector2d> found = camera.CamFromImg(image_point);
  if (!found) {
    return false;
  }
  *ray = *found;
#else
  *ray = camera.CamFromImg(image_point);
#endif
  return ray->allFinite();
}

bool ImagePointFromRay(const colmap::Camera& camera,
                       const Eigen::Vector2d& ray,
                       Eigen::Vector2d* image_point) {
#if STRUCTNERF_COLMAP_VERSION >= 31200
  const std::optional<Eigen::Vector2d> found =
      camera.ImgFromCam(ray.homogeneous());
  if (!found) {
    return false;
  }
  *image_point = *found;
#else
  *image_point = camera.ImgFromCam(ray);
#endif
  return image_point->allFinite();
}

bool ReadImageHeader(const std::string& path, ImageHeader* header) {
#if STRUCTNERF_COLMAP_VERSION >= 40000
  colmap::Bitmap bitmap;
  if (!bitmap.Read(path)) {
    return false;
  }
  *header = {bitmap.Width(), bitmap.Height(), /*has_readable_colors=*/true};
  return true;
#else
  const FREE_IMAGE_FORMAT format = FreeImage_GetFileType(path.c_str(), 0);
  if (format == FIF_UNKNOWN) {
    return false;
  }
  FIBITMAP* bitmap = FreeImage_Load(format, path.c_str(), FIF_LOAD_NOPIXELS);
  if (bitmap == nullptr) {
    return false;
  }
  const FREE_IMAGE_TYPE type = FreeImage_GetImageType(bitmap);
  *header = {static_cast<int>(FreeImage_GetWidth(bitmap)),
             static_cast<int>(FreeImage_GetHeight(bitmap)),
             type == FIT_BITMAP || type == FIT_RGB16 || type == FIT_RGBA16};
  FreeImage_Unload(bitmap);
  return true;
#endif
}

void CreateUndistortedWorkspace(const colmap::Reconstruction& reconstruction,
                                const std::string& image_path,
                                const std::string& output_path,
                                const std::function<bool()>& should_stop) {
  const colmap::UndistortCameraOptions camera_options;
#if STRUCTNERF_COLMAP_VERSION >= 40000
  colmap::COLMAPUndistorter undistorter(colmap::COLMAPUndistorter::Options(),
                                        camera_options,
                                        reconstruction,
                                        image_path,
                                        output_path);
#else
  colmap::COLMAPUndistorter undistorter(
      camera_options, reconstruction, image_path, output_path);
#endif
  bool stopped = false;
  undistorter.SetCheckIfStoppedFunc([&]() {
    stopped = stopped || should_stop();
    return stopped;
  });
  try {
    undistorter.Run();
  } catch (const std::exception& error) {
    throw std::runtime_error(
        std::string("The images could not be undistorted (") + error.what() +
        "); is the disk full?");
  }
  if (!stopped) {
    CheckUndistorted(reconstruction, output_path);
  }
}

}  // namespace structnerf
