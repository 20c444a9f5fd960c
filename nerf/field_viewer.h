#pragma once

#include "nerf/engine/engine_factory.h"
#include "nerf/options.h"
#include "nerf/progress.h"
#include "nerf/rendered_view.h"
#include "nerf/scene.h"

#include <memory>
#include <string>

namespace structnerf {

// Looks at a field that Reconstructor has trained and saved, from anywhere.
class FieldViewer {
 public:
  // `options` and the poses, cameras and points of `scene` must be those of the
  // training; photographs are not needed. Throws std::runtime_error, naming the
  // file, if it is damaged or belongs to other options or another scene;
  // std::invalid_argument if options or scene are wrong.
  FieldViewer(Scene scene,
              const ReconstructionOptions& options,
              const std::string& field_path,
              const EngineFactory& make_engine);

  // With MakeGridEngine.
  FieldViewer(Scene scene,
              const ReconstructionOptions& options,
              const std::string& field_path);
  ~FieldViewer();

  // Whether the camera is in the box that the field fills (nerf/scene_frame.h).
  bool Contains(const View& view) const;

  // `view.image` may be empty. Throws Aborted if told to.
  //   scene_view_idx: the view of the scene whose latent code colour is to
  //     have, or, if training held it out, what TrainingOptions::latent_test
  //     says; -1 = a code of zeros. Only fields with such codes read it.
  RenderedView Render(const View& view,
                      int scene_view_idx,
                      Progress* progress) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace structnerf
