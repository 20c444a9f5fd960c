#include "nerf/analysis/surface_size.h"

#include "nerf/train/depth_prior.h"

#include <cstdint>
#include <unordered_set>
#include <vector>

#include <Eigen/LU>

namespace structnerf {
namespace {

// Cells are counted in a coarse grid, in which few rays per view leave no gaps,
// and grow with the square of the resolution, as surfaces do.
constexpr int kCountedResolution = 32;
constexpr int kRaysPerRow = 24;
constexpr int kRaysPerColumn = 18;

// Points per view that its depth is interpolated from.
constexpr size_t kMaxSamples = 200;

// Of a point in the box.
uint64_t CellAt(const Eigen::Vector3d& x_in_field) {
  // The box ends at 1.
  uint64_t cell = 0;
  for (int axis = 0; axis < 3; ++axis) {
    cell = cell * (kCountedResolution + 1) +
           static_cast<uint64_t>(kCountedResolution * x_in_field[axis]);
  }
  return cell;
}

std::vector<DepthSample> Thinned(const std::vector<DepthSample>& samples) {
  const size_t stride = (samples.size() + kMaxSamples - 1) / kMaxSamples;
  std::vector<DepthSample> thinned;
  for (size_t i = 0; i < samples.size(); i += stride) {
    thinned.push_back(samples[i]);
  }
  return thinned;
}

bool IsInBox(const Eigen::Vector3d& x_in_field, const SceneFrame& frame) {
  return (x_in_field.array() >= 0).all() &&
         (x_in_field.array() <= frame.extent.cast<double>().array()).all();
}

}  // namespace

double CountSurfaceCells(const Scene& scene,
                         const SceneFrame& frame,
                         const int resolution) {
  const std::vector<std::vector<DepthSample>> samples =
      CollectDepthSamples(scene);
  std::unordered_set<uint64_t> cells;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    if (samples[v].empty()) {
      continue;
    }
    const std::vector<DepthSample> thinned = Thinned(samples[v]);
    const View& view = scene.views[v];
    const PinholeCamera camera = view.ImageCamera();
    const Eigen::Matrix3d camera_from_pixel =
        camera.CalibrationMatrix().inverse();
    for (int row = 0; row < kRaysPerColumn; ++row) {
      for (int col = 0; col < kRaysPerRow; ++col) {
        const double x = (col + 0.5) * camera.width / kRaysPerRow;
        const double y = (row + 0.5) * camera.height / kRaysPerColumn;
        const Eigen::Vector3d x_in_cam =
            InterpolateDepth(thinned, x, y) *
            (camera_from_pixel * Eigen::Vector3d(x, y, 1));
        const Eigen::Vector3d x_in_field =
            frame.FieldFromWorld(view.WorldFromCam(x_in_cam));
        if (IsInBox(x_in_field, frame)) {
          cells.insert(CellAt(x_in_field));
        }
      }
    }
  }
  const double growth = static_cast<double>(resolution) / kCountedResolution;
  return growth * growth * static_cast<double>(cells.size());
}

}  // namespace structnerf
