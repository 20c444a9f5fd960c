#pragma once

#include "colmap_plugin/evaluation/compared_maps.h"
#include "colmap_plugin/evaluation/comparison.h"
#include "colmap_plugin/evaluation/truth_views.h"

#include <array>
#include <string>
#include <vector>

namespace structnerf {

struct PictureSources {
  std::array<const ComparedMaps*, 2> maps;
  TruthViews* truth = nullptr;  // null = none
};

// Pictures of one view in two rows:
//   photograph   depth A   normals A   error A   difference of the depths
//   true depth   depth B   normals B   error B   whose error is smaller
// The row of the truth, the errors and the last picture are missing without
// truth; the difference is below the photograph then. What a workspace does not
// have is an empty picture. The scales are the comparison's, whose numbers must
// be complete.
std::vector<std::vector<HtmlPicture>> MakeComparisonPictures(
    const Comparison& comparison,
    const PictureSources& sources,
    const std::string& name);

}  // namespace structnerf
