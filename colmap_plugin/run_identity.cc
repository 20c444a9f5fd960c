#include "colmap_plugin/run_identity.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/masks.h"
#include "nerf/method_options.h"
#include "nerf/util/checksummed_file.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <type_traits>
#include <variant>
#include <vector>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// As many digits as tell the number from all others.
std::string ExactText(const OptionValue& value) {
  return std::visit(
      [](const auto& typed) -> std::string {
        if constexpr (std::is_same_v<std::decay_t<decltype(typed)>,
                                     std::string>) {
          return typed;
        } else {
          char text[32];
          const auto number = [&]() {
            if constexpr (std::is_same_v<std::decay_t<decltype(typed)>, bool>) {
              return static_cast<int>(typed);
            } else {
              return typed;
            }
          }();
          return {text, std::to_chars(text, text + sizeof(text), number).ptr};
        }
      },
      value);
}

void AddText(const std::string& text, Checksum* checksum) {
  const uint64_t size = text.size();
  checksum->Add(&size, sizeof(size));
  checksum->Add(text.data(), text.size());
}

template <typename T>
void AddNumber(const T& number, Checksum* checksum) {
  static_assert(std::is_arithmetic_v<T>);
  checksum->Add(&number, sizeof(number));
}

void AddFile(const std::string& path, Checksum* checksum) {
  std::error_code error;
  AddText(path, checksum);
  AddNumber(fs::file_size(path, error), checksum);
  AddNumber(fs::last_write_time(path, error).time_since_epoch().count(),
            checksum);
}

}  // namespace

std::map<std::string, std::string> DescribeRun(
    const StructNerfOptions& options) {
  std::map<std::string, std::string> run = {
      {"version", STRUCTNERF_VERSION}, {"--StructNeRF.device", options.device}};
  ReconstructionOptions reconstruction = options.reconstruction;
  for (const OptionEntry& entry : MakeMethodOptionEntries(&reconstruction)) {
    if (entry.name != "StructNeRF.num_threads") {
      run["--" + entry.name] = ExactText(entry.Value());
    }
  }
  return run;
}

std::string InputFingerprint(const colmap::Reconstruction& reconstruction,
                             const std::string& image_path,
                             const std::string& mask_path) {
  Checksum checksum;
  for (const colmap::image_t image_id : RegisteredImageIds(reconstruction)) {
    const colmap::Image& image = reconstruction.Image(image_id);
    const colmap::Camera& camera = reconstruction.Camera(image.CameraId());
    AddNumber(image_id, &checksum);
    AddText(image.Name(), &checksum);
    AddText(camera.ModelName(), &checksum);
    AddNumber(camera.width, &checksum);
    AddNumber(camera.height, &checksum);
    AddText(camera.ParamsToString(), &checksum);
    const Eigen::Matrix3x4d pose = image.CamFromWorld().ToMatrix();
    checksum.Add(pose.data(), pose.size() * sizeof(double));
    for (colmap::point2D_t i = 0; i < image.NumPoints2D(); ++i) {
      AddNumber(image.Point2D(i).xy.x(), &checksum);
      AddNumber(image.Point2D(i).xy.y(), &checksum);
      AddNumber(image.Point2D(i).point3D_id, &checksum);
    }
    AddFile((fs::path(image_path) / image.Name()).string(), &checksum);
    if (!mask_path.empty()) {
      AddFile(MaskPath(mask_path, image.Name()), &checksum);
    }
  }
  std::vector<colmap::point3D_t> point_ids;
  for (const auto& [point3D_id, point3D] : reconstruction.Points3D()) {
    point_ids.push_back(point3D_id);
  }
  std::sort(point_ids.begin(), point_ids.end());
  for (const colmap::point3D_t point3D_id : point_ids) {
    const colmap::Point3D& point = reconstruction.Point3D(point3D_id);
    AddNumber(point3D_id, &checksum);
    checksum.Add(point.xyz.data(), 3 * sizeof(double));
    AddNumber(point.error, &checksum);
  }
  return checksum.Text();
}

}  // namespace structnerf
