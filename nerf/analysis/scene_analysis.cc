#include "nerf/analysis/scene_analysis.h"

#include "nerf/analysis/point_colors.h"
#include "nerf/analysis/surface_size.h"
#include "nerf/train/depth_prior.h"
#include "nerf/util/median.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <set>
#include <string>

namespace structnerf {
namespace {

constexpr double kPixelsPerCell = 1.5;
constexpr int kMinMaxResolution = 64;
constexpr int kMaxMaxResolution = 8192;

constexpr double kMaxGrowth = 4;

constexpr double kCellsPerEntry = 4;
constexpr int kMinLog2TableSize = 12;
constexpr int kMaxLog2TableSize = 21;

constexpr int kMinPatchDilation = 3;
constexpr int kMaxPatchDilation = 16;
constexpr double kSizePerPatchPixel = 270;

template <typename... Values>
std::string Text(const char* format, const Values... values) {
  char text[160];
  snprintf(text, sizeof(text), format, values...);
  return text;
}

SceneDecision DescribeBox(const Scene& scene, const SceneFrame& frame) {
  const Eigen::Array3d extent = frame.extent.cast<double>();
  size_t num_inside = 0;
  for (const SparsePoint& point : scene.points) {
    const Eigen::Array3d x = frame.FieldFromWorld(point.xyz).array();
    num_inside += (x >= 0).all() && (x <= extent).all();
  }
  const Eigen::Array3d sides = extent / frame.scale;
  return {"scene box",
          Text("%.4g x %.4g x %.4g", sides.x(), sides.y(), sides.z()),
          Text("holds all cameras and %.1f %% of the sparse points",
               100.0 * num_inside / scene.points.size())};
}

// Of a training image, as it is or, if it is not loaded, will be.
PinholeCamera TrainingCamera(const View& view, const int max_image_size) {
  return view.image.data.empty() ? view.camera.Reduced(max_image_size)
                                 : view.ImageCamera();
}

// What a pixel of the training images covers at the median depth of the scene,
// in field units; the median over the views.
double PixelFootprint(const Scene& scene,
                      const SceneFrame& frame,
                      const int max_image_size) {
  std::vector<double> footprints;
  for (const View& view : scene.views) {
    const PinholeCamera camera = TrainingCamera(view, max_image_size);
    footprints.push_back(frame.median_depth / std::sqrt(camera.fx * camera.fy));
  }
  return Median(&footprints);
}

SceneDecision ChooseResolution(const Scene& scene,
                               const SceneFrame& frame,
                               const int max_image_size,
                               FieldOptions* field) {
  SceneDecision decision{"finest grid level", "", "as told"};
  if (field->max_resolution == kFromScene) {
    const double footprint = PixelFootprint(scene, frame, max_image_size);
    field->max_resolution = static_cast<int>(std::clamp(
        std::round(1 / (kPixelsPerCell * footprint)),
        static_cast<double>(std::max(kMinMaxResolution, field->min_resolution)),
        static_cast<double>(kMaxMaxResolution)));
    decision.reason =
        Text("at the median depth, a training pixel covers 1/%.0f of the box",
             1 / footprint);
  }
  decision.choice = Text("%d cells along the box", field->max_resolution);
  return decision;
}

SceneDecision ChooseNumLevels(FieldOptions* field) {
  SceneDecision decision{"grid levels", "", "as told"};
  const double growth =
      static_cast<double>(field->max_resolution) / field->min_resolution;
  if (field->num_levels == kFromScene) {
    field->num_levels =
        1 + static_cast<int>(
                std::ceil(std::log(growth) / std::log(kMaxGrowth) - 1e-9));
    decision.reason =
        Text("the finest is %.0f times finer than the coarsest", growth);
  }
  decision.choice = std::to_string(field->num_levels);
  return decision;
}

SceneDecision ChooseTableSize(const Scene& scene,
                              const SceneFrame& frame,
                              FieldOptions* field) {
  SceneDecision decision{"grid table", "", "as told"};
  if (field->log2_table_size == kFromScene) {
    const double num_cells =
        CountSurfaceCells(scene, frame, field->max_resolution);
    field->log2_table_size = std::clamp(
        static_cast<int>(
            std::floor(std::log2(std::max(1.0, num_cells / kCellsPerEntry)))),
        kMinLog2TableSize,
        kMaxLog2TableSize);
    decision.reason = Text(
        "surfaces pass through about %.0f cells of the "
        "finest level",
        num_cells);
  }
  decision.choice = Text("2^%d entries a level", field->log2_table_size);
  return decision;
}

SceneDecision ChoosePatchDilation(const Scene& scene,
                                  const int max_image_size,
                                  LossOptions* loss) {
  SceneDecision decision{"patches", "", "as told"};
  if (loss->patch_dilation == kFromScene) {
    std::vector<double> sizes;
    for (const View& view : scene.views) {
      const PinholeCamera camera = TrainingCamera(view, max_image_size);
      sizes.push_back(std::max(camera.width, camera.height));
    }
    const double size = Median(&sizes);
    loss->patch_dilation =
        std::clamp(static_cast<int>(std::lround(size / kSizePerPatchPixel)),
                   kMinPatchDilation,
                   kMaxPatchDilation);
    decision.reason =
        Text("training images have %.0f pixels along their longer side", size);
  }
  decision.choice = Text("taps %d pixels apart", loss->patch_dilation);
  return decision;
}

SceneDecision DescribeSamples(const Scene& scene,
                              const SceneFrame& frame,
                              const int num_samples) {
  std::vector<double> ratios;  // of the largest depth in a view to the nearest
  for (const std::vector<DepthSample>& samples : CollectDepthSamples(scene)) {
    double farthest = 0;
    for (const DepthSample& sample : samples) {
      farthest = std::max(farthest, sample.depth);
    }
    ratios.push_back(std::max(1.0, farthest * frame.scale / frame.near));
  }
  const double ratio = Median(&ratios);
  return {"samples",
          Text("%d a ray", num_samples),
          Text("spread evenly over depths up to %.0f times the nearest, they "
               "would be %.0f %% apart",
               ratio,
               100 * (std::pow(ratio, 1.0 / num_samples) - 1))};
}

SceneDecision DescribeColor(const Scene& scene, const FieldOptions& field) {
  const bool is_on = field.type == "mlp" || field.direction_degree > 0;
  return {"view-dependent colour",
          is_on ? "on" : "off",
          Text("colours in which photographs show a point differ by %.1f %% of "
               "the range",
               100 * MeasureColorSpread(scene))};
}

SceneDecision DescribeSources(const Scene& scene, const LossOptions& loss) {
  const size_t num_views = scene.views.size();
  std::vector<uint8_t> are_neighbors(num_views * num_views, 0);
  for (const SparsePoint& point : scene.points) {
    for (const Observation& observation : point.track) {
      for (const Observation& other : point.track) {
        are_neighbors[observation.view_idx * num_views + other.view_idx] =
            observation.view_idx != other.view_idx;
      }
    }
  }
  std::vector<double> counts;
  for (size_t v = 0; v < num_views; ++v) {
    const auto of_view = are_neighbors.begin() + v * num_views;
    counts.push_back(
        static_cast<double>(std::count(of_view, of_view + num_views, 1)));
  }
  return {"source views",
          Text("up to %d a view", loss.num_sources),
          Text("in the median, a view shares sparse points with %.0f of %zu "
               "others",
               Median(&counts),
               scene.views.size() - 1)};
}

// Of the pixels that the planar term is to act on.
SceneDecision DescribeSuperpixels(const Scene& scene, const LossOptions& loss) {
  size_t num_superpixels = 0;
  size_t num_pixels = 0;
  size_t num_planar = 0;
  for (const View& view : scene.views) {
    std::set<int32_t> labels;
    for (const int32_t label : view.segments) {
      if (label >= 0) {
        labels.insert(label);
        ++num_planar;
      }
    }
    num_pixels += view.segments.size();
    num_superpixels += labels.size();
  }
  const bool is_on = loss.planar_weight > 0 && num_superpixels > 0;
  return {"planar term",
          is_on ? "on" : "off",
          Text("%zu large superpixels cover %.0f %% of the images",
               num_superpixels,
               100.0 * num_planar / std::max<size_t>(1, num_pixels))};
}

bool HasPhotographs(const Scene& scene) {
  return std::none_of(scene.views.begin(),
                      scene.views.end(),
                      [](const View& view) { return view.image.data.empty(); });
}

bool HasSegments(const Scene& scene) {
  return std::any_of(scene.views.begin(),
                     scene.views.end(),
                     [](const View& view) { return !view.segments.empty(); });
}

}  // namespace

SceneAnalysis AnalyzeScene(const Scene& scene,
                           const ReconstructionOptions& options) {
  SceneAnalysis analysis{options, ComputeSceneFrame(scene), {}};
  const SceneFrame& frame = analysis.frame;
  analysis.decisions.push_back(DescribeBox(scene, frame));
  FieldOptions& field = analysis.options.field;
  if (field.type == "grid") {
    analysis.decisions.push_back(ChooseResolution(
        scene, frame, options.training.max_image_size, &field));
    analysis.decisions.push_back(ChooseNumLevels(&field));
    analysis.decisions.push_back(ChooseTableSize(scene, frame, &field));
  }
  analysis.decisions.push_back(ChoosePatchDilation(
      scene, options.training.max_image_size, &analysis.options.loss));
  analysis.decisions.push_back(
      DescribeSamples(scene, frame, options.sampling.num_samples));
  if (HasPhotographs(scene)) {
    analysis.decisions.push_back(DescribeColor(scene, options.field));
  }
  analysis.decisions.push_back(DescribeSources(scene, options.loss));
  if (HasSegments(scene)) {
    analysis.decisions.push_back(DescribeSuperpixels(scene, options.loss));
  }
  return analysis;
}

}  // namespace structnerf
