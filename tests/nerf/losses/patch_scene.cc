#include "tests/nerf/losses/patch_scene.h"

namespace structnerf {

SceneFrame MakePatchFrame() {
  SceneFrame frame;
  frame.origin = Eigen::Vector3d(-3, -2, -1);
  frame.scale = 0.125;
  return frame;
}

PatchResult EvaluatePatches(const Scene& scene,
                            const PatchSources& sources,
                            const PatchLoss::Options& options,
                            const std::vector<PatchPixel>& pixels,
                            const std::vector<double>& depths) {
  const SceneFrame frame = MakePatchFrame();
  const TrainingViews views(scene, frame);
  const PatchLoss patch_loss(scene, frame, views, sources, options);
  std::vector<int> view_idx;
  std::vector<int> col;
  std::vector<int> row;
  std::vector<float> depth;
  for (size_t i = 0; i < pixels.size(); ++i) {
    view_idx.push_back(pixels[i].view_idx);
    col.push_back(pixels[i].col);
    row.push_back(pixels[i].row);
    depth.push_back(static_cast<float>(depths[i] * frame.scale));
  }
  PatchResult result;
  // What must be overwritten.
  result.loss.assign(pixels.size(), -7.0f);
  result.d_depth.assign(pixels.size(), -7.0f);
  result.num_valid.assign(pixels.size(), -7);
  patch_loss.Evaluate(static_cast<int>(pixels.size()),
                      view_idx.data(),
                      col.data(),
                      row.data(),
                      depth.data(),
                      result.loss.data(),
                      result.d_depth.data(),
                      result.num_valid.data());
  for (float& derivative : result.d_depth) {
    derivative *= static_cast<float>(frame.scale);
  }
  return result;
}

Scene MakeStereoPair(const double shift) {
  Scene scene;
  const PinholeCamera camera = MakeCamera(32, 24, 100);
  scene.views = {
      MakeView("left", camera, Eigen::Vector3d::Zero()),
      MakeView("right", camera, Eigen::Vector3d(0.01 * shift, 0, 0))};
  return scene;
}

Scene MakeSlantedScene(TexturedPlane* plane) {
  plane->normal = Eigen::Vector3d(0.3, -0.2, -1);
  plane->wavelength = 0.9;
  Scene scene;
  scene.views = {
      MakeView("a", MakeCamera(48, 36, 50), Eigen::Vector3d(0, 0, 0)),
      MakeView("b",
               {56, 40, 61, 58, 26, 21.5},
               Eigen::Vector3d(0.4, 0.1, 0.3),
               Eigen::Vector3d(-0.1, 0.02, 1)),
      MakeView("c",
               MakeCamera(96, 80, 97),
               Eigen::Vector3d(-0.35, 0.2, -0.2),
               Eigen::Vector3d(0.08, -0.05, 1))};
  plane->Photograph(48, 36, &scene.views[0]);
  plane->Photograph(56, 40, &scene.views[1]);
  plane->Photograph(48, 40, &scene.views[2]);
  return scene;
}

}  // namespace structnerf
