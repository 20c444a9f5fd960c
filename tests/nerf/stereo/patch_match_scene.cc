#include "tests/nerf/stereo/patch_match_scene.h"

#include <cmath>
#include <cstring>

namespace structnerf {

Scene MakeMatchedScene(TexturedPlane* plane) {
  plane->normal = Eigen::Vector3d(0.4, -0.25, -1);
  plane->wavelength = 0.35;
  Scene scene;
  const PinholeCamera camera = MakeCamera(67, 48, 90);
  scene.views = {MakeView("middle", camera, Eigen::Vector3d(0, 0, 0)),
                 MakeView("right",
                          camera,
                          Eigen::Vector3d(0.7, 0.1, 0.1),
                          Eigen::Vector3d(-0.17, 0, 1)),
                 MakeView("left",
                          camera,
                          Eigen::Vector3d(-0.6, -0.2, 0),
                          Eigen::Vector3d(0.15, 0.03, 1)),
                 MakeView("above",
                          MakeCamera(140, 100, 190),
                          Eigen::Vector3d(0.1, -0.7, -0.1),
                          Eigen::Vector3d(0, 0.16, 1))};
  for (size_t v = 0; v < 3; ++v) {
    plane->Photograph(67, 48, &scene.views[v]);
  }
  plane->Photograph(70, 50, &scene.views[3]);
  return scene;
}

PlaneMaps MakePlanes(const TexturedPlane& plane,
                     const View& view,
                     const double scale) {
  PlaneMaps maps;
  maps.width = view.image.width;
  maps.height = view.image.height;
  const auto rho = [&](const double x, const double y) {
    const double ratio_x = static_cast<double>(view.camera.width) / maps.width;
    const double ratio_y =
        static_cast<double>(view.camera.height) / maps.height;
    return 1 / (scale * plane.Depth(view, x * ratio_x, y * ratio_y));
  };
  for (int row = 0; row < maps.height; ++row) {
    for (int col = 0; col < maps.width; ++col) {
      const double x = col + 0.5;
      const double y = row + 0.5;
      maps.rho.push_back(static_cast<float>(rho(x, y)));
      maps.rho_x.push_back(static_cast<float>(rho(x + 1, y) - rho(x, y)));
      maps.rho_y.push_back(static_cast<float>(rho(x, y + 1) - rho(x, y)));
    }
  }
  return maps;
}

PlaneMaps RefinePlanes(const Scene& scene,
                       const PatchSources& sources,
                       const StereoOptions& options,
                       const PlaneMaps& seed,
                       const int num_threads) {
  const SceneFrame frame = MakePatchFrame();
  const TrainingViews views(scene, frame);
  const PatchMatch patch_match(scene, frame, views, sources, options);
  ThreadPool pool(num_threads);
  PlaneMaps maps = seed;
  Progress progress;
  patch_match.Refine(0, &pool, &progress, &maps);
  return maps;
}

bool SamePlanes(const PlaneMaps& a, const PlaneMaps& b) {
  const auto same = [](const std::vector<float>& x,
                       const std::vector<float>& y) {
    return x.size() == y.size() &&
           std::memcmp(x.data(), y.data(), x.size() * sizeof(float)) == 0;
  };
  return same(a.rho, b.rho) && same(a.rho_x, b.rho_x) && same(a.rho_y, b.rho_y);
}

bool SamePlane(const PlaneMaps& a, const PlaneMaps& b, const size_t i) {
  return a.rho[i] == b.rho[i] && a.rho_x[i] == b.rho_x[i] &&
         a.rho_y[i] == b.rho_y[i];
}

double ShareWithin(const PlaneMaps& maps,
                   const PlaneMaps& truth,
                   const int margin,
                   const double tolerance) {
  int num_good = 0;
  int num_all = 0;
  for (int row = margin; row < maps.height - margin; ++row) {
    for (int col = margin; col < maps.width - margin; ++col) {
      const size_t i = static_cast<size_t>(row) * maps.width + col;
      num_good += std::abs(maps.rho[i] / truth.rho[i] - 1) < tolerance;
      ++num_all;
    }
  }
  return static_cast<double>(num_good) / num_all;
}

}  // namespace structnerf
