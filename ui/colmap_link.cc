#include "ui/colmap_link.h"

#include <filesystem>
#include <utility>

namespace structnerf {
namespace {

// A string or a path, depending on COLMAP's version.
template <typename Path>
std::function<std::string()> Getter(const std::shared_ptr<Path>& path) {
  return [path]() { return std::filesystem::path(*path).string(); };
}

}  // namespace

ColmapLink::ColmapLink(const colmap::OptionManager& manager)
    : image_path_(Getter(manager.image_path)),
      project_path_(Getter(manager.project_path)),
      fusion_(manager.stereo_fusion),
      render_(manager.render) {}

std::string ColmapLink::ImagePath() const { return image_path_(); }

std::string ColmapLink::ProjectPath() const { return project_path_(); }

std::shared_ptr<const colmap::Reconstruction> ColmapLink::Model() const {
  return viewer_->reconstruction != nullptr && viewer_->reconstruction == cloud_
             ? model_
             : viewer_->reconstruction;
}

void ColmapLink::ShowCloud(std::shared_ptr<colmap::Reconstruction> cloud) {
  if (viewer_->reconstruction != cloud_ || cloud_ == nullptr) {
    model_ = viewer_->reconstruction;
    model_min_track_len_ = render_->min_track_len;
  }
  cloud_ = std::move(cloud);
  // Points of a cloud have no track.
  render_->min_track_len = 0;
  viewer_->reconstruction = cloud_;
  viewer_->ReloadReconstruction();
}

void ColmapLink::Update() {
  if (cloud_ == nullptr || viewer_->reconstruction == cloud_) {
    return;
  }
  if (render_->min_track_len == 0) {  // else it was changed since
    render_->min_track_len = model_min_track_len_;
  }
  cloud_.reset();
  model_.reset();
}

void ColmapLink::ShowModel() {
  if (cloud_ == nullptr || viewer_->reconstruction != cloud_) {
    return;
  }
  render_->min_track_len = model_min_track_len_;
  if (model_ == nullptr) {
    viewer_->ClearReconstruction();  // reloading none leaves the cloud
    return;
  }
  viewer_->reconstruction = model_;
  viewer_->ReloadReconstruction();
}

}  // namespace structnerf
