#include "colmap_plugin/depth_priors.h"

#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/text_output.h"
#include "nerf/prior_module.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// Throws if the map does not cover the camera's field of view.
void CheckShape(const std::string& path,
                const StereoMaps& map,
                const PinholeCamera& camera) {
  const double scale = static_cast<double>(map.width) / camera.width;
  // Sizes are rounded when maps are made from reduced images.
  const bool is_same_shape =
      map.width > 0 && std::abs(scale * camera.height - map.height) <= 1;
  if (!is_same_shape) {
    throw std::runtime_error(
        "The depth map " + path + " is " + SizeText(map.width, map.height) +
        ", but its camera is " + SizeText(camera.width, camera.height) +
        "; make the maps from the undistorted images of this model.");
  }
}

// COLMAP's maps have the pixel (col, row) at the image point (col, row).
std::vector<float> ResampleDepth(const StereoMaps& map, const RgbImage& image) {
  std::vector<float> depths;
  depths.reserve(static_cast<size_t>(image.width) * image.height);
  const auto nearest = [](const int i, const int size, const int map_size) {
    const double place = (i + 0.5) * map_size / size;
    return std::min(static_cast<int>(std::lround(place)), map_size - 1);
  };
  for (int row = 0; row < image.height; ++row) {
    const size_t map_row = nearest(row, image.height, map.height);
    for (int col = 0; col < image.width; ++col) {
      const float depth =
          map.depth[map_row * map.width + nearest(col, image.width, map.width)];
      depths.push_back(depth > 0 && std::isfinite(depth) ? depth : 0.0f);
    }
  }
  return depths;
}

}  // namespace

std::vector<std::string> LoadDepthPriors(const std::string& folder,
                                         const std::string& type,
                                         Scene* scene) {
  std::vector<std::string> missing;
  for (View& view : scene->views) {
    const std::string path =
        (fs::path(folder) / (view.name + "." + type + ".bin")).string();
    if (!fs::exists(path)) {
      missing.push_back(view.name);
      continue;
    }
    const StereoMaps map = ReadDepthMap(path);
    CheckShape(path, map, view.camera);
    view.prior_depth = ResampleDepth(map, view.image);
  }
  if (missing.size() == scene->views.size()) {
    throw std::runtime_error(
        "The folder " + folder +
        " of --StructNeRF.prior_path has no depth map " + "<image name>." +
        type +
        ".bin of any image; give the depth_maps folder of a workspace, or "
        "another --StructNeRF.prior_type.");
  }
  return missing;
}

std::vector<std::string> LoadPriors(const std::string& path,
                                    const std::string& type,
                                    Progress* progress,
                                    Scene* scene) {
  if (fs::is_regular_file(path)) {
    PredictPriors(path, progress, scene);
    return {};
  }
  if (!fs::is_directory(path)) {
    throw std::runtime_error("The path " + path +
                             " of --StructNeRF.prior_path is neither a folder "
                             "of depth maps nor a TorchScript module.");
  }
  std::vector<std::string> sentences;
  for (const std::string& name : LoadDepthPriors(path, type, scene)) {
    sentences.push_back("image " + name + " has no " + type + " depth map in " +
                        path + "; it is trained without a prior");
  }
  return sentences;
}

}  // namespace structnerf
