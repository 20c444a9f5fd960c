#include "colmap_plugin/tradeoff/tradeoff_run.h"

#include "colmap_plugin/child_process.h"
#include "colmap_plugin/dense_workspace.h"
#include "colmap_plugin/evaluation/map_pictures.h"
#include "colmap_plugin/evaluation/photograph_prediction.h"
#include "colmap_plugin/evaluation/workspace_maps.h"
#include "colmap_plugin/input_check.h"
#include "colmap_plugin/json_text.h"
#include "colmap_plugin/png_file.h"
#include "colmap_plugin/run_identity.h"
#include "colmap_plugin/text_output.h"
#include "nerf/util/quantile.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include <nlohmann/json.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using nlohmann::json;

// Of kErrorThresholds: 5 cm.
constexpr size_t kThresholdIdx = 1;

// Views of which one is held out, if there are so many, and that are needed for
// that.
constexpr int kTestEvery = 8;
constexpr int kMinNumTestedViews = 3;

// Shares of the depths of a picture that are nearer and farther than its scale.
constexpr double kClippedShare = 0.02;

fs::path RunFolder(const TradeoffScene& scene,
                   const TradeoffSetting& setting,
                   const int seed) {
  return fs::path(scene.output_path) / "runs" / setting.FolderName() /
         ("seed" + std::to_string(seed));
}

// The same for any way to write it; empty stays empty.
std::string CanonicalPath(const std::string& path) {
  if (path.empty()) {
    return "";
  }
  const fs::path canonical = fs::weakly_canonical(path);
  return (canonical.has_filename() ? canonical : canonical.parent_path())
      .string();
}

json ReadJson(const fs::path& path) {
  std::ifstream file(path);
  try {
    return json::parse(file);
  } catch (const json::exception& error) {
    throw std::runtime_error("The file " + path.string() +
                             " cannot be understood (" + error.what() +
                             "); remove its folder to measure anew.");
  }
}

// What a measurement, or a run that has not been measured yet, belongs to.
json DescribeMeasurement(const TradeoffScene& scene,
                         const TradeoffSetting& setting) {
  const json description = {{"images", scene.image_path},
                            {"model", scene.input_path},
                            {"masks", scene.mask_path},
                            {"truth", scene.truth.path},
                            {"truth_scale", scene.truth.scale},
                            {"fingerprint", scene.fingerprint},
                            {"test_every", scene.test_every},
                            {"setting", setting.name}};
  // As a file has it, which is UTF-8 whatever the paths are.
  return json::parse(JsonText(description));
}

void RequireSame(const json& found,
                 const json& expected,
                 const TradeoffScene& scene) {
  if (found != expected) {
    throw std::runtime_error(
        "The output folder " + scene.output_path +
        " holds runs on other images, masks or ground truth, or on another "
        "model; choose another --output_path, or remove that folder.");
  }
}

SceneScale EstimateScale(const TruthViews& truth, const TradeoffScene& scene) {
  const SceneScale scale = truth.EstimateScale();
  if (scale.num_observations == 0) {
    throw std::runtime_error(
        "The scale of the model is not known, because no sparse point has "
        "ground truth in " +
        scene.truth.path +
        "; correct --ground_truth_path, or leave it out to measure by "
        "photographs that are kept out instead.");
  }
  return scale;
}

// Of these maps alone: the rest of an evaluation takes longer and is not
// needed.
double ErrorAgainstTruth(const TradeoffScene& scene,
                         const WorkspaceMaps& maps) {
  const colmap::Reconstruction model = ReadModel(scene.input_path);
  TruthViews truth(model, scene.image_path, scene.truth);
  const SceneScale scale = EstimateScale(truth, scene);
  const auto source = [&](const std::string& name) { return maps.Find(name); };
  Progress silent;
  StageProgress stage("Evaluating maps", &silent);
  return 1 - EvaluateDepth(truth.Names(), source, scale, &truth, &stage)
                 .in_sfm_scale->all.within[kThresholdIdx];
}

double MeasureError(const TradeoffScene& scene,
                    const DenseWorkspace& workspace,
                    const colmap::Reconstruction& model,
                    const json& report) {
  switch (ErrorKind(scene)) {
    case TradeoffError::kTruth:
      return ErrorAgainstTruth(
          scene, WorkspaceMaps(workspace, model, MapType::kPhotometric));
    case TradeoffError::kHeldOut:
      return PredictHeldOutPhotographs(workspace, model, scene.test_every)
          .ShareWrong();
    default: {
      const json& counts = report.at("maps");
      return 1 - counts.at("geometric_pixels").get<double>() /
                     counts.at("pixels").get<double>();
    }
  }
}

void WritePicture(const cv::Mat1f& depth, const std::string& path) {
  std::vector<float> values;
  for (const float value : depth) {
    if (value > 0 && std::isfinite(value)) {
      values.push_back(value);
    }
  }
  const auto quantile = [&](const double share) {
    return values.empty() ? 1.0f : Quantile(&values, share);
  };
  const float nearest = quantile(kClippedShare);
  const float farthest = quantile(1 - kClippedShare);
  WritePng(path, DepthPicture(depth, nearest, farthest));
}

void Run(const TradeoffScene& scene,
         const TradeoffSetting& setting,
         const int seed,
         const std::string& workspace_path) {
  std::vector<std::string> arguments = {
      "structnerf_dense",
      "--image_path",
      scene.image_path,
      "--input_path",
      scene.input_path,
      "--output_path",
      workspace_path,
      "--StructNeRF.seed=" + std::to_string(seed),
      // The time is that of the whole run.
      "--StructNeRF.resume=0"};
  if (!scene.mask_path.empty()) {
    arguments.insert(arguments.end(), {"--mask_path", scene.mask_path});
  }
  if (scene.test_every > 0) {
    arguments.push_back("--StructNeRF.test_every=" +
                        std::to_string(scene.test_every));
  }
  arguments.insert(
      arguments.end(), setting.arguments.begin(), setting.arguments.end());
  if (RunChildProcess("/proc/self/exe", arguments, /*keep_output=*/false) !=
      0) {
    throw std::runtime_error("The run with " + setting.name +
                             " did not end well; what was measured before is "
                             "kept. Once what it says is mended, the same "
                             "command goes on from there.");
  }
}

}  // namespace

TradeoffError ErrorKind(const TradeoffScene& scene) {
  return !scene.truth.path.empty() ? TradeoffError::kTruth
         : scene.test_every > 0    ? TradeoffError::kHeldOut
                                   : TradeoffError::kAgreement;
}

void PrepareScene(TradeoffScene* scene) {
  for (std::string* const path : {&scene->image_path,
                                  &scene->input_path,
                                  &scene->mask_path,
                                  &scene->truth.path}) {
    *path = CanonicalPath(*path);
  }
  const colmap::Reconstruction model = ReadModel(scene->input_path);
  CheckModel(model);
  CheckImages(model, scene->image_path);
  CheckMasks(model, scene->mask_path);
  scene->fingerprint =
      InputFingerprint(model, scene->image_path, scene->mask_path);
  const auto num_views = static_cast<int>(model.NumRegImages());
  if (!scene->truth.path.empty()) {
    EstimateScale(TruthViews(model, scene->image_path, scene->truth), *scene);
  } else if (num_views >= kMinNumTestedViews) {
    scene->test_every = std::min(kTestEvery, num_views);
  }
}

TradeoffMeasurement MeasureSetting(const TradeoffScene& scene,
                                   const TradeoffSetting& setting,
                                   const int seed) {
  const fs::path folder = RunFolder(scene, setting, seed);
  const fs::path path = folder / "measurement.json";
  const json description = DescribeMeasurement(scene, setting);
  TradeoffMeasurement measurement;
  if (fs::exists(path)) {
    const json old = ReadJson(path);
    RequireSame(old.at("of"), description, scene);
    measurement.seconds = old.at("seconds");
    measurement.cpu_seconds = old.at("cpu_seconds");
    measurement.peak_bytes = old.at("peak_bytes");
    measurement.error = old.at("error");
    measurement.held_out_psnr = old.at("held_out_psnr");
    return measurement;
  }

  const std::string workspace_path = (folder / "workspace").string();
  const fs::path report_path =
      fs::path(DenseWorkspace(workspace_path).ReportFolder()) / "report.json";
  const fs::path run_path = folder / "run.json";
  if (!fs::exists(report_path)) {
    fs::create_directories(folder);
    WriteTextFile(run_path.string(), JsonText(description));
    Run(scene, setting, seed, workspace_path);
  }
  // It may have ended long ago, without having been measured.
  RequireSame(
      fs::exists(run_path) ? ReadJson(run_path) : json(), description, scene);
  const json report = ReadJson(report_path);
  if (report.at("training").at("stopped_early")) {
    fs::remove_all(workspace_path);
    throw std::runtime_error(
        "Quit before the end; the same command goes on from what was "
        "measured.");
  }
  measurement.seconds = report.at("seconds");
  measurement.cpu_seconds = report.at("cpu_seconds");
  measurement.peak_bytes = report.at("memory").at("peak_bytes");
  measurement.held_out_psnr =
      report.at("training").at("held_out_psnr").is_number()
          ? report.at("training").at("held_out_psnr").get<double>()
          : -1;
  const DenseWorkspace workspace(workspace_path);
  const colmap::Reconstruction model = ReadModel(workspace.SparsePath());
  measurement.error = MeasureError(scene, workspace, model, report);
  const WorkspaceMaps maps(workspace, model, MapType::kPhotometric);
  const std::vector<std::string> names = ImageNames(model);
  WritePicture(maps.Find(names[names.size() / 2]).value().depth,
               TradeoffPicturePath(scene, setting, seed));
  WriteTextFile(path.string(),
                JsonText({{"of", description},
                          {"seconds", measurement.seconds},
                          {"cpu_seconds", measurement.cpu_seconds},
                          {"peak_bytes", measurement.peak_bytes},
                          {"error", measurement.error},
                          {"held_out_psnr", measurement.held_out_psnr}}));
  fs::remove_all(workspace_path);
  fs::remove(run_path);
  return measurement;
}

std::string TradeoffPicturePath(const TradeoffScene& scene,
                                const TradeoffSetting& setting,
                                const int seed) {
  return (RunFolder(scene, setting, seed) / "depth.png").string();
}

}  // namespace structnerf
