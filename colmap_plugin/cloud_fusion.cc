#include "colmap_plugin/cloud_fusion.h"

#include "colmap_plugin/centred_workspace.h"
#include "colmap_plugin/memory_budget.h"
#include "nerf/util/whole_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <type_traits>

#include <colmap/util/endian.h>
#include <colmap/util/ply.h>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// Colour, depth, normal and state of one pixel.
constexpr size_t kBytesPerPixel = 3 + 4 + 12 + 1;

// COLMAP queues one task per so many rows, each with a copy of the view's
// pixel states.
constexpr size_t kRowsPerTask = 10;

// Fused point, its visibility list and their copies while they are gathered at
// the end, and before that, what growing lists of them take.
constexpr size_t kBytesPerPoint = 250;
constexpr size_t kBytesPerGrowingPoint = 190;

// Points per pixel times StereoFusion's min_num_pixels: a point takes as many
// pixels at least. Measured: 0.09 with 2, 0.03 to 0.045 with 5.
constexpr double kPointsPerPixelGroup = 0.2;

constexpr int kMinFusionImageSize = 320;

// As colmap::WriteBinaryPlyPoints, which does not notice a full disk, but with
// positions of any precision. COLMAP reads them all, and rounds them to float.
template <typename Position>
void WritePlyPoints(const std::vector<colmap::PlyPoint>& points,
                    const Eigen::Vector3d& offset,
                    std::ostream* stream) {
  const char* const position_type =
      std::is_same_v<Position, double> ? "double" : "float";
  *stream << "ply\nformat binary_little_endian 1.0\nelement vertex "
          << points.size() << "\n";
  for (const char* axis : {"x", "y", "z"}) {
    *stream << "property " << position_type << " " << axis << "\n";
  }
  for (const char* property : {"float nx",
                               "float ny",
                               "float nz",
                               "uchar red",
                               "uchar green",
                               "uchar blue"}) {
    *stream << "property " << property << "\n";
  }
  *stream << "end_header\n";
  for (const colmap::PlyPoint& point : points) {
    const Eigen::Vector3d xyz =
        offset + Eigen::Vector3d(point.x, point.y, point.z);
    for (int axis = 0; axis < 3; ++axis) {
      colmap::WriteBinaryLittleEndian<Position>(
          stream, static_cast<Position>(xyz[axis]));
    }
    for (const float component : {point.nx, point.ny, point.nz}) {
      colmap::WriteBinaryLittleEndian<float>(stream, component);
    }
    for (const uint8_t channel : {point.r, point.g, point.b}) {
      colmap::WriteBinaryLittleEndian<uint8_t>(stream, channel);
    }
  }
}

// COLMAP's writer does not notice a full disk either, but the size tells.
void WriteVisibility(const std::string& path,
                     const std::vector<std::vector<int>>& visibility) {
  size_t num_bytes = sizeof(uint64_t);
  for (const auto& image_idxs : visibility) {
    num_bytes += (1 + image_idxs.size()) * sizeof(uint32_t);
  }
  colmap::mvs::WritePointsVisibility(path, visibility);
  std::error_code error;
  if (fs::file_size(path, error) != num_bytes || error) {
    throw std::runtime_error("The file " + path +
                             " could not be written; is the disk full?");
  }
}

// `offset`: what is added to the points. Single precision would round points at
// 1e7 to one unit.
void WriteCloud(const std::string& path,
                const std::vector<colmap::PlyPoint>& points,
                const std::vector<std::vector<int>>& visibility,
                const Eigen::Vector3d& offset) {
  const std::string visibility_path = path + ".vis";
  const std::string partial_visibility_path = visibility_path + ".partial";
  WriteVisibility(partial_visibility_path, visibility);
  WriteWholeFile(path, [&](std::ostream* stream) {
    if (offset.isZero(0)) {
      WritePlyPoints<float>(points, offset, stream);
    } else {
      WritePlyPoints<double>(points, offset, stream);
    }
  });
  fs::rename(partial_visibility_path, visibility_path);
}

}  // namespace

int MinNumPixels(const colmap::mvs::StereoFusionOptions& options,
                 const size_t num_views) {
  if (options.min_num_pixels > 0) {
    return options.min_num_pixels;
  }
  const auto wanted =
      static_cast<int>(std::clamp<size_t>(num_views / 10, 2, 5));
  return std::max(1, std::min(wanted, options.max_num_pixels));
}

void ForgetDefaultMinNumPixels(colmap::mvs::StereoFusionOptions* options) {
  if (options->min_num_pixels ==
      colmap::mvs::StereoFusionOptions().min_num_pixels) {
    options->min_num_pixels = 0;
  }
}

size_t EstimateFusionMemory(const colmap::mvs::StereoFusionOptions& options,
                            const std::vector<PinholeCamera>& cameras) {
  size_t num_pixels = 0;
  size_t max_queue_bytes = 0;
  for (const PinholeCamera& camera : cameras) {
    const double longest = std::max(camera.width, camera.height);
    const double scale = options.max_image_size > 0
                             ? std::min(1.0, options.max_image_size / longest)
                             : 1.0;
    const auto width = static_cast<size_t>(std::ceil(scale * camera.width));
    const auto height = static_cast<size_t>(std::ceil(scale * camera.height));
    num_pixels += width * height;
    max_queue_bytes =
        std::max(max_queue_bytes, width * height * (1 + height / kRowsPerTask));
  }
  const auto num_points =
      static_cast<size_t>(num_pixels * kPointsPerPixelGroup /
                          MinNumPixels(options, cameras.size()));
  const size_t num_map_bytes =
      options.use_cache
          ? num_pixels + static_cast<size_t>(options.cache_size * kBytesPerGb)
          : num_pixels * kBytesPerPixel;
  return num_map_bytes +
         std::max(max_queue_bytes + num_points * kBytesPerGrowingPoint,
                  num_points * kBytesPerPoint);
}

std::string FitFusionIntoMemory(const std::vector<PinholeCamera>& cameras,
                                const size_t max_bytes,
                                colmap::mvs::StereoFusionOptions* options) {
  if (EstimateFusionMemory(*options, cameras) <= max_bytes) {
    return "";
  }
  options->use_cache = true;
  options->cache_size =
      std::min(options->cache_size, 0.25 * max_bytes / kBytesPerGb);
  int longest = 0;
  for (const PinholeCamera& camera : cameras) {
    longest = std::max({longest, camera.width, camera.height});
  }
  std::string sentence =
      "Fusion reads the maps through a cache, on one thread, to stay within "
      "the memory limit";
  while (EstimateFusionMemory(*options, cameras) > max_bytes) {
    const int size = options->max_image_size > 0
                         ? std::min(options->max_image_size, longest)
                         : longest;
    options->max_image_size = size * 3 / 4;
    if (options->max_image_size < kMinFusionImageSize) {
      throw std::runtime_error(
          "Fusing the maps needs more memory than allowed; raise "
          "--StructNeRF.max_memory_gb.");
    }
  }
  if (options->max_image_size > 0 && options->max_image_size < longest) {
    sentence += ", with maps reduced to " +
                std::to_string(options->max_image_size) + " pixels";
  }
  return sentence + ".";
}

size_t FuseMaps(const DenseWorkspace& workspace,
                const MapType map_type,
                const colmap::mvs::StereoFusionOptions& options,
                const size_t num_views,
                Progress* progress) {
  const CentredWorkspace centred(workspace);
  colmap::mvs::StereoFusion fusion(options,
                                   centred.Path(),
                                   /*workspace_format=*/"COLMAP",
                                   /*pmvs_option_name=*/"",
                                   MapTypeName(map_type));
  // COLMAP asks whether to stop once after loading and once before each view,
  // which tells how far it is.
  size_t num_calls = 0;
  bool aborted = false;
  ProgressUpdate update;
  update.stage = "Fusing points";
  fusion.SetCheckIfStoppedFunc([&]() {
    update.fraction =
        std::min(1.0, static_cast<double>(num_calls++) / (num_views + 1));
    progress->Report(update);
    progress->BlockWhilePaused();
    aborted = aborted || progress->ShouldAbort();
    return aborted;
  });
  fusion.Run();
  if (aborted) {
    throw Aborted();
  }
  std::vector<std::vector<int>> visibility = fusion.GetFusedPointsVisibility();
  for (std::vector<int>& image_idxs : visibility) {
    for (int& image_idx : image_idxs) {
      image_idx = centred.ImageIdxs()[image_idx];
    }
  }
  WriteCloud(workspace.FusedPath(),
             fusion.GetFusedPoints(),
             visibility,
             centred.Offset());
  update.fraction = 1;
  progress->Report(update);
  return fusion.GetFusedPoints().size();
}

std::string EmptyCloudText(const MapType map_type,
                           const bool has_geometric,
                           const int min_num_pixels) {
  const bool is_geometric = map_type == MapType::kGeometric;
  std::string text = "No points were fused, because ";
  if (is_geometric && !has_geometric) {
    text += "no pixel's depth was confirmed by other views";
  } else {
    text += "no point was seen by " + std::to_string(min_num_pixels) +
            " pixels of different views";
  }
  text += "; add images that overlap more";
  if (is_geometric) {
    text += ", or pass --StructNeRF.input_type photometric";
  }
  if (min_num_pixels > 1) {
    text += ", or --StereoFusion.min_num_pixels " +
            std::to_string(min_num_pixels - 1);
  }
  return text + ".";
}

}  // namespace structnerf
