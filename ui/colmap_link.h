#pragma once

#include <QAction>
#include <functional>
#include <memory>
#include <string>

#include <colmap/controllers/option_manager.h>
#include <colmap/scene/reconstruction.h>
#include <colmap/ui/model_viewer_widget.h>

namespace structnerf {

// What our widgets share with COLMAP's window: its viewer, and the options of
// the project that is open. COLMAP replaces the values of these options when
// another project is opened, never the objects.
class ColmapLink {
 public:
  // To be called before the manager is handed to the window.
  explicit ColmapLink(const colmap::OptionManager& manager);

  void SetViewer(colmap::ModelViewerWidget* viewer) { viewer_ = viewer; }

  // See MainWindowHook.
  void SetPauseAction(const QAction* action) { pause_action_ = action; }

  // Whether COLMAP's mapper is at work on the model.
  bool IsMapping() const {
    return pause_action_ != nullptr && pause_action_->isEnabled();
  }

  // Of the project; empty if there is none.
  std::string ImagePath() const;
  std::string ProjectPath() const;

  const colmap::mvs::StereoFusionOptions& FusionOptions() const {
    return *fusion_;
  }

  // The model that the viewer shows, or whose cloud it shows; null if none.
  std::shared_ptr<const colmap::Reconstruction> Model() const;

  // Shows a cloud that was made from a model, or the model again.
  void ShowCloud(std::shared_ptr<colmap::Reconstruction> cloud);
  void ShowModel();

  // To be called now and then: undoes what ShowCloud() did once another model
  // is shown.
  void Update();

 private:
  std::function<std::string()> image_path_;
  std::function<std::string()> project_path_;
  std::shared_ptr<colmap::mvs::StereoFusionOptions> fusion_;
  std::shared_ptr<colmap::RenderOptions> render_;
  colmap::ModelViewerWidget* viewer_ = nullptr;
  const QAction* pause_action_ = nullptr;

  // What ShowCloud() put in place of `model_`.
  std::shared_ptr<colmap::Reconstruction> cloud_;
  std::shared_ptr<colmap::Reconstruction> model_;
  int model_min_track_len_ = 0;
};

}  // namespace structnerf
