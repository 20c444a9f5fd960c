#include "tests/stability/room_run.h"

#include "nerf/engine/torch_factory.h"
#include "nerf/extract/consistency.h"
#include "nerf/util/median.h"
#include "nerf/util/random.h"
#include "tests/nerf/plane_scene.h"
#include "tests/stability/stability_case.h"

#include <cmath>

namespace structnerf {
namespace {

// See DenseMaps.
void CheckMaps(const View& view, const DenseMaps& maps) {
  const size_t num_pixels = view.camera.NumPixels();
  RequireStable(maps.depth.size() == num_pixels &&
                    maps.normal.size() == 3 * num_pixels &&
                    maps.relative_std.size() == num_pixels,
                "the maps have a wrong size");
  for (size_t i = 0; i < num_pixels; ++i) {
    const Eigen::Vector3d normal(maps.normal[i],
                                 maps.normal[num_pixels + i],
                                 maps.normal[2 * num_pixels + i]);
    RequireStable(std::isfinite(maps.depth[i]) && maps.depth[i] >= 0,
                  "a depth is " + ShortNumber(maps.depth[i]));
    RequireStable(std::isfinite(maps.relative_std[i]),
                  "a deviation is " + ShortNumber(maps.relative_std[i]));
    RequireStable(maps.depth[i] > 0 ? std::abs(normal.norm() - 1) < 1e-3
                                    : normal.norm() == 0,
                  "a normal has the length " + ShortNumber(normal.norm()));
  }
}

// The photometric maps: matched depth where views confirm it, the field's
// elsewhere.
void TakeConfirmed(const Reconstructor& reconstructor,
                   const Scene& scene,
                   std::vector<DenseMaps>* matched,
                   std::vector<DenseMaps>* field) {
  ThreadPool pool(1);
  Progress progress;
  std::vector<std::vector<uint8_t>> is_confirmed;
  for (size_t v = 0; v < matched->size(); ++v) {
    is_confirmed.push_back(CheckConsistency(scene,
                                            *matched,
                                            v,
                                            reconstructor.SourceViews()[v],
                                            reconstructor.Options().extraction,
                                            &pool,
                                            &progress)
                               .is_confirmed);
  }
  for (size_t v = 0; v < matched->size(); ++v) {
    ReplaceUnconfirmed(is_confirmed[v], (*field)[v], &(*matched)[v]);
  }
  field->swap(*matched);
}

const std::vector<RoomTruth>& Truths() {
  static const std::vector<RoomTruth> truths = [] {
    std::vector<RoomTruth> all;
    for (size_t v = 0; v < StabilityRoom().images.size(); ++v) {
      all.push_back(CastTruth(
          StabilityRoom(), static_cast<int>(v), PixelPoint::kInteger));
    }
    return all;
  }();
  return truths;
}

// Where the views see a point of the room, with noise.
std::vector<Observation> Observe(const Scene& scene,
                                 const Eigen::Vector3d& xyz,
                                 Random* random) {
  constexpr double kNoise = 1.0;  // largest, pixels
  std::vector<Observation> track;
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const PinholeCamera& camera = scene.views[v].camera;
    const Eigen::Vector3d point = Project(scene.views[v], xyz);
    if (!(point.z() > 0 && point.x() > 1 && point.x() < camera.width - 1 &&
          point.y() > 1 && point.y() < camera.height - 1)) {
      continue;
    }
    const float depth =
        Truths()[v].depth[static_cast<size_t>(point.y()) * camera.width +
                          static_cast<size_t>(point.x())];
    if (std::abs(depth / point.z() - 1) < 0.05) {
      const Eigen::Vector2d noise(kNoise * (random->NextFloat() - 0.5),
                                  kNoise * (random->NextFloat() - 0.5));
      track.push_back({static_cast<int>(v), point.head<2>() + noise});
    }
  }
  return track;
}

std::vector<SparsePoint> SampleTruth(const Scene& scene) {
  constexpr int kStride = 8;
  std::vector<SparsePoint> points;
  Random random(2);
  for (size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = scene.views[v];
    for (int row = kStride / 2; row < view.camera.height; row += kStride) {
      for (int col = kStride / 2; col < view.camera.width; col += kStride) {
        const double depth =
            Truths()[v]
                .depth[static_cast<size_t>(row) * view.camera.width + col];
        const Eigen::Vector3d in_view(
            depth * (col - view.camera.cx) / view.camera.fx,
            depth * (row - view.camera.cy) / view.camera.fy,
            depth);
        SparsePoint point;
        point.xyz = view.WorldFromCam(in_view);
        point.error = 1.5 * random.NextFloat();
        point.track = Observe(scene, point.xyz, &random);
        if (point.track.size() >= 2) {
          points.push_back(point);
        }
      }
    }
  }
  return points;
}

}  // namespace

const SyntheticRoom& StabilityRoom() {
  static const SyntheticRoom room = [] {
    SyntheticRoomOptions options;
    options.num_views = 6;
    options.width = 64;
    options.height = 48;
    return MakeSyntheticRoom(options);
  }();
  return room;
}

const Scene& StabilityScene() {
  static const Scene scene = [] {
    Scene created = MakeScene(StabilityRoom());
    created.points = SampleTruth(created);
    return created;
  }();
  return scene;
}

ReconstructionOptions StabilityOptions() {
  ReconstructionOptions options;
  options.field.log2_table_size = 13;
  options.field.max_resolution = 256;
  options.sampling.cache_resolution = 48;
  options.training.num_steps = 200;
  options.training.rays_per_step = 256;
  options.loss.patch_dilation = 1;
  options.training.num_threads = 2;
  return options;
}

RoomRun RunScene(const Scene& scene, const ReconstructionOptions& options) {
  Reconstructor reconstructor(scene, options, MakeAnyEngine);
  Progress progress;
  reconstructor.Train(&progress);
  RoomRun run;
  run.summary = reconstructor.Summary();
  run.warnings = reconstructor.Warnings();
  RequireStable(std::isfinite(run.summary.final_loss), "the loss is infinite");
  std::vector<DenseMaps> matched;
  run.maps.resize(scene.views.size());
  for (size_t v = 0; v < scene.views.size(); ++v) {
    matched.push_back(reconstructor.RenderView(v, &progress, &run.maps[v]));
    CheckMaps(scene.views[v], matched.back());
  }
  if (options.MatchesViews()) {
    TakeConfirmed(reconstructor, scene, &matched, &run.maps);
  }
  return run;
}

const RoomRun& BaseRun() {
  static const RoomRun run = RunScene(StabilityScene(), StabilityOptions());
  return run;
}

const RoomRun& OtherSeedRun() {
  static const RoomRun run = [] {
    ReconstructionOptions options = StabilityOptions();
    options.training.seed = 1;
    return RunScene(StabilityScene(), options);
  }();
  return run;
}

double MedianError(const std::vector<DenseMaps>& maps,
                   const double world_scale) {
  std::vector<double> errors;
  for (size_t v = 0; v < maps.size(); ++v) {
    for (size_t i = 0; i < maps[v].depth.size(); ++i) {
      errors.push_back(
          100 *
          std::abs(maps[v].depth[i] / world_scale / Truths()[v].depth[i] - 1));
    }
  }
  return Median(&errors);
}

std::string GuardText(const TrainingSummary& summary) {
  std::string text;
  for (const auto& [name, count] : summary.guard_counts) {
    if (count > 0) {
      text += (text.empty() ? "; guards: " : ", ") + name + " " +
              std::to_string(count);
    }
  }
  return text;
}

std::string MeasureScene(const Scene& scene,
                         const ReconstructionOptions& options,
                         const double max_error) {
  const RoomRun run = RunScene(scene, options);
  const double error = MedianError(run.maps);
  const std::string text = "error " + ShortNumber(error) + " %, base " +
                           ShortNumber(MedianError(BaseRun().maps)) + " %" +
                           GuardText(run.summary);
  RequireStable(error <= max_error, text);
  return text;
}

}  // namespace structnerf
