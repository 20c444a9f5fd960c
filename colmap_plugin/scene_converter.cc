#include "colmap_plugin/scene_converter.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/image_file.h"
#include "colmap_plugin/masks.h"
#include "colmap_plugin/superpixels.h"
#include "colmap_plugin/text_output.h"
#include "nerf/scene_guards.h"
#include "nerf/util/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <unordered_map>

#include <colmap/image/undistortion.h>

#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

View ConvertPose(const colmap::Reconstruction& reconstruction,
                 const colmap::image_t image_id) {
  const colmap::Image& image = reconstruction.Image(image_id);
  const colmap::Camera& camera = reconstruction.Camera(image.CameraId());
  if (!camera.IsUndistorted()) {
    throw std::runtime_error(
        "The camera of image " + image.Name() +
        " is not undistorted; use the model of the dense workspace that "
        "structnerf_dense or COLMAP's image_undistorter makes of the original "
        "images.");
  }
  View view;
  view.name = image.Name();
  view.camera = ToPinholeCamera(camera);
  const Eigen::Matrix<double, 3, 4> cam_from_world =
      image.CamFromWorld().ToMatrix();
  view.cam_from_world_rotation = cam_from_world.leftCols<3>();
  view.cam_from_world_translation = cam_from_world.col(3);
  return view;
}

cv::Mat ReadImage(const SceneConverterOptions& options, const View& view) {
  const cv::Mat image = ReadColorImage(
      (std::filesystem::path(options.image_path) / view.name).string());
  if (image.empty()) {
    throw std::runtime_error("The undistorted image " + view.name +
                             " cannot be read; it is damaged, or the disk is "
                             "full.");
  }
  if (image.cols != view.camera.width || image.rows != view.camera.height) {
    throw std::runtime_error("The undistorted image " + view.name + " is " +
                             SizeText(image.cols, image.rows) +
                             ", but its camera is " +
                             SizeText(view.camera.width, view.camera.height) +
                             "; undistort the images again with this model.");
  }
  return image;
}

void LoadPixels(const SceneConverterOptions& options, View* view) {
  const cv::Mat full_image = ReadImage(options, *view);
  const PinholeCamera reduced = view->camera.Reduced(options.max_image_size);
  const cv::Size size(reduced.width, reduced.height);
  cv::Mat image;
  cv::resize(full_image, image, size, 0, 0, cv::INTER_AREA);
  cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
  view->image.width = size.width;
  view->image.height = size.height;
  view->image.data.assign(image.datastart, image.dataend);

  if (!options.mask_path.empty()) {
    std::vector<uint8_t> full_mask = ReadMask(
        options.mask_path, view->name, view->camera.width, view->camera.height);
    if (!full_mask.empty()) {
      cv::Mat mask(
          view->camera.height, view->camera.width, CV_8U, full_mask.data());
      cv::resize(mask, mask, size, 0, 0, cv::INTER_AREA);
      // A reduced pixel is used only if all it covers is.
      cv::threshold(mask, mask, 254, 255, cv::THRESH_BINARY);
      view->mask.assign(mask.datastart, mask.dataend);
    }
  }

  if (options.planar_min_area > 0) {
    const double area_ratio =
        static_cast<double>(size.area()) / view->camera.NumPixels();
    view->segments = FindLargeSuperpixels(
        view->image,
        std::max(1, static_cast<int>(options.planar_min_area * area_ratio)));
  }
}

std::vector<SparsePoint> ConvertPoints(
    const colmap::Reconstruction& reconstruction,
    const std::unordered_map<colmap::image_t, int>& view_idxs) {
  std::vector<colmap::point3D_t> point3D_ids;
  for (const auto& point3D : reconstruction.Points3D()) {
    point3D_ids.push_back(point3D.first);
  }
  std::sort(point3D_ids.begin(), point3D_ids.end());

  std::vector<SparsePoint> points;
  points.reserve(point3D_ids.size());
  for (const colmap::point3D_t point3D_id : point3D_ids) {
    const auto& point3D = reconstruction.Point3D(point3D_id);
    SparsePoint point;
    point.xyz = point3D.xyz;
    point.error = point3D.HasError() ? point3D.error : -1;
    for (const auto& element : point3D.track.Elements()) {
      const auto view_idx = view_idxs.find(element.image_id);
      if (view_idx != view_idxs.end()) {
        const colmap::Image& image = reconstruction.Image(element.image_id);
        point.track.push_back(
            {view_idx->second, image.Point2D(element.point2D_idx).xy});
      }
    }
    points.push_back(std::move(point));
  }
  return points;
}

}  // namespace

PinholeCamera ToPinholeCamera(const colmap::Camera& camera) {
  return {static_cast<int>(camera.width),
          static_cast<int>(camera.height),
          camera.FocalLengthX(),
          camera.FocalLengthY(),
          camera.PrincipalPointX(),
          camera.PrincipalPointY()};
}

Scene ConvertGeometry(const colmap::Reconstruction& reconstruction) {
  Scene scene;
  std::unordered_map<colmap::image_t, int> view_idxs;
  for (const colmap::image_t image_id : RegisteredImageIds(reconstruction)) {
    view_idxs.emplace(image_id, static_cast<int>(scene.views.size()));
    scene.views.push_back(ConvertPose(reconstruction, image_id));
  }
  scene.points = ConvertPoints(reconstruction, view_idxs);
  return scene;
}

Scene OutlineScene(const colmap::Reconstruction& reconstruction) {
  colmap::Reconstruction undistorted = reconstruction;
  colmap::UndistortReconstruction(colmap::UndistortCameraOptions(),
                                  &undistorted);
  Scene scene = ConvertGeometry(undistorted);
  RemoveContradictoryPoints(&scene);
  return scene;
}

Scene ConvertScene(const colmap::Reconstruction& reconstruction,
                   const SceneConverterOptions& options,
                   Progress* progress) {
  Scene scene = ConvertGeometry(reconstruction);
  std::atomic<size_t> num_done{0};
  ThreadPool(options.num_threads)
      .ParallelFor(
          scene.views.size(), [&](const size_t view_idx, const int thread) {
            LoadPixels(options, &scene.views[view_idx]);
            ++num_done;
            if (thread == 0) {  // who called us
              ReportItems(
                  "Loading images", num_done, scene.views.size(), progress);
            }
          });
  return scene;
}

}  // namespace structnerf
