#include "nerf/field_viewer.h"

#include "nerf/engine/scene_engine_options.h"
#include "nerf/extract/view_renderer.h"
#include "nerf/field/field_file.h"
#include "nerf/scene_frame.h"
#include "nerf/scene_guards.h"
#include "nerf/view_selection.h"

#include <stdexcept>
#include <utility>
#include <vector>

namespace structnerf {

class FieldViewer::Impl {
 public:
  SceneFrame frame;
  std::unique_ptr<RenderEngine> engine;
  std::vector<Appearance> appearances;
};

FieldViewer::FieldViewer(Scene scene,
                         const ReconstructionOptions& options,
                         const std::string& field_path,
                         const EngineFactory& make_engine)
    : impl_(std::make_unique<Impl>()) {
  std::string error;
  if (!options.Check(&error)) {
    throw std::invalid_argument(error);
  }
  // The box is that of the points that training kept.
  RemoveContradictoryPoints(&scene);
  impl_->frame = ComputeSceneFrame(scene);
  const FieldParameters parameters =
      ReadField(field_path, options.field, impl_->frame.extent);
  impl_->engine =
      make_engine(MakeEngineOptions(options, impl_->frame, scene.views.size()));
  impl_->engine->SetParameters(parameters);
  Progress silent;
  impl_->engine->RebuildDensityCache(&silent);

  impl_->appearances = SelectAppearances(
      scene.views.size(),
      HeldOutViewIdxs(scene.views.size(), options.training.test_every),
      options.training.latent_test);
}

FieldViewer::FieldViewer(Scene scene,
                         const ReconstructionOptions& options,
                         const std::string& field_path)
    : FieldViewer(std::move(scene), options, field_path, MakeGridEngine) {}

FieldViewer::~FieldViewer() = default;

bool FieldViewer::Contains(const View& view) const {
  const Eigen::Array3d position =
      impl_->frame.FieldFromWorld(view.ProjectionCenter()).array();
  return (position >= 0).all() &&
         (position <= impl_->frame.extent.cast<double>().array()).all();
}

RenderedView FieldViewer::Render(const View& view,
                                 const int scene_view_idx,
                                 Progress* progress) const {
  return RenderPixelCenters(view,
                            view.camera,
                            impl_->frame,
                            scene_view_idx >= 0
                                ? impl_->appearances.at(scene_view_idx)
                                : kNoAppearance,
                            impl_->engine.get(),
                            progress);
}

}  // namespace structnerf
