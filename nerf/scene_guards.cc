#include "nerf/scene_guards.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <stdexcept>

namespace structnerf {
namespace {

// Grey levels that the pixels of a view of a single colour may span: what
// compression leaves of it.
constexpr int kMaxPlainRange = 2;

bool HasSingleColor(const View& view) {
  uint8_t low[3] = {255, 255, 255};
  uint8_t high[3] = {0, 0, 0};
  bool has_pixel = false;
  const size_t num_pixels = view.image.data.size() / 3;
  for (size_t i = 0; i < num_pixels; ++i) {
    if (!view.mask.empty() && view.mask[i] == 0) {
      continue;
    }
    has_pixel = true;
    for (int c = 0; c < 3; ++c) {
      const uint8_t value = view.image.data[3 * i + c];
      low[c] = std::min(low[c], value);
      high[c] = std::max(high[c], value);
      if (high[c] - low[c] > kMaxPlainRange) {
        return false;
      }
    }
  }
  return has_pixel;
}

}  // namespace

SceneFindings InspectScene(const Scene& scene,
                           const std::vector<std::vector<int>>& sources) {
  if (std::all_of(sources.begin(), sources.end(), [](const auto& of_view) {
        return of_view.empty();
      })) {
    throw std::invalid_argument(
        "no image has another one to compare it with: all cameras stand in one "
        "place, or they look apart and share no sparse points. Depth needs "
        "images that see the same things from different places");
  }
  std::vector<size_t> num_points(scene.views.size(), 0);
  for (const SparsePoint& point : scene.points) {
    for (const Observation& observation : point.track) {
      ++num_points[observation.view_idx];
    }
  }
  SceneFindings findings;
  int& num_without_points = findings.counts["view_without_points"];
  int& num_without_baseline = findings.counts["view_without_baseline"];
  int& num_plain = findings.counts["view_of_single_color"];
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const std::string prefix = "image " + scene.views[v].name + " ";
    if (num_points[v] == 0) {
      ++num_without_points;
      findings.warnings.push_back(
          prefix +
          "sees no sparse point; its depth rests on other views "
          "alone");
    }
    if (sources[v].empty()) {
      ++num_without_baseline;
      findings.warnings.push_back(prefix +
                                  "has no source view with a baseline; it is "
                                  "compared with nothing");
    }
    if (HasSingleColor(scene.views[v])) {
      ++num_plain;
      findings.warnings.push_back(prefix +
                                  "shows a single colour; its depth rests on "
                                  "sparse points and other views alone");
    }
  }
  return findings;
}

}  // namespace structnerf
