#pragma once

#include "nerf/scene.h"

#include <map>
#include <string>
#include <vector>

namespace structnerf {

// What is odd about a scene that can still be trained on.
struct SceneFindings {
  std::vector<std::string> warnings;  // sentences that name the image

  // How many views each guard found, by its name.
  std::map<std::string, int> counts;
};

// Looks for views without sparse points, views that no other one with a
// baseline can be compared with (identical cameras, pure rotation), and views
// of a single colour. `sources`: see SelectSourceViews. Throws
// std::invalid_argument if no view has any source: nothing then tells depth.
SceneFindings InspectScene(const Scene& scene,
                           const std::vector<std::vector<int>>& sources);

}  // namespace structnerf
