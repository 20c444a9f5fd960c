#pragma once

#include "colmap_plugin/structnerf_options.h"
#include "nerf/scene.h"

#include <memory>
#include <string>
#include <vector>

#include <colmap/scene/reconstruction.h>

namespace structnerf {

// What a run on a model will be like, in sentences, before it has begun.
struct RunExpectation {
  std::string text;
  bool is_possible = false;  // else the text says why not
};

// Foretells runs on one model.
class RunForecast {
 public:
  explicit RunForecast(
      std::shared_ptr<const colmap::Reconstruction> reconstruction);

  RunExpectation Expect(const StructNerfOptions& options) const;

  // Of the registered images, undistorted.
  const std::vector<PinholeCamera>& Cameras() const { return cameras_; }

 private:
  const std::shared_ptr<const colmap::Reconstruction> reconstruction_;
  std::string error_;  // why no run is possible
  std::vector<PinholeCamera> cameras_;
  Scene outline_;
};

}  // namespace structnerf
