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

// Counts sparse points that do not project to where their views saw them: in
// the mean over the track, more than 8 pixels and 2 % of the camera's longer
// side off, where one behind a view counts as far off. They are removed unless
// they are more than half of all: then it is the poses that must be wrong.
int RemoveContradictoryPoints(Scene* scene);

// Looks for views without sparse points, views that no other one with a
// baseline can be compared with (identical cameras, pure rotation), views of a
// single colour, and cameras far from all others. `sources`: see
// SelectSourceViews. Throws std::invalid_argument if no view has any source:
// nothing then tells depth.
//   num_contradictory: see RemoveContradictoryPoints.
SceneFindings InspectScene(const Scene& scene,
                           const std::vector<std::vector<int>>& sources,
                           int num_contradictory);

}  // namespace structnerf
