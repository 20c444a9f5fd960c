#include "colmap_plugin/run_report.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/json_text.h"
#include "colmap_plugin/memory_budget.h"
#include "colmap_plugin/text_output.h"
#include "nerf/util/cpu_time.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <thread>

#include <nlohmann/json.hpp>
#include <opencv2/core/version.hpp>

namespace structnerf {
namespace {

using nlohmann::json;

// Raised when a field changes its name or meaning.
constexpr int kSchemaVersion = 1;

std::string CpuModel() {
  std::ifstream file("/proc/cpuinfo");
  std::string line;
  while (std::getline(file, line)) {
    const size_t colon = line.find(": ");
    if (line.compare(0, 10, "model name") == 0 && colon != std::string::npos) {
      return line.substr(colon + 2);
    }
  }
  return "unknown";
}

struct Totals {
  size_t num_pixels = 0;
  size_t num_photometric = 0;
  size_t num_geometric = 0;
  double seconds = 0;
  double cpu_seconds = 0;

  explicit Totals(const RunReport& report) {
    for (const ViewReport& view : report.views) {
      num_pixels += static_cast<size_t>(view.width) * view.height;
      num_photometric += view.num_photometric;
      num_geometric += view.num_geometric;
    }
    for (const StageReport& stage : report.stages) {
      seconds += stage.seconds;
      cpu_seconds += stage.cpu_seconds;
    }
  }
};

double SamplesPerSecond(const TrainingSummary& training) {
  return training.seconds > 0 ? training.num_samples / training.seconds : 0;
}

json OptionsJson(const std::map<std::string, OptionValue>& options) {
  json object = json::object();
  for (const auto& [name, value] : options) {
    std::visit([&, &name = name](const auto& typed) { object[name] = typed; },
               value);
  }
  return object;
}

json VectorJson(const Eigen::Vector3f& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

json ViewsJson(const std::vector<ViewReport>& views) {
  json array = json::array();
  for (const ViewReport& view : views) {
    array.push_back({{"name", view.name},
                     {"width", view.width},
                     {"height", view.height},
                     {"photometric_pixels", view.num_photometric},
                     {"geometric_pixels", view.num_geometric},
                     {"exposure",
                      {{"gain", VectorJson(view.exposure.gain)},
                       {"offset", VectorJson(view.exposure.offset)}}}});
  }
  return array;
}

json DecisionsJson(const std::vector<SceneDecision>& decisions) {
  json array = json::array();
  for (const SceneDecision& decision : decisions) {
    array.push_back({{"subject", decision.subject},
                     {"choice", decision.choice},
                     {"reason", decision.reason}});
  }
  return array;
}

json StagesJson(const std::vector<StageReport>& stages) {
  json array = json::array();
  for (const StageReport& stage : stages) {
    array.push_back({{"name", stage.name},
                     {"seconds", stage.seconds},
                     {"cpu_seconds", stage.cpu_seconds}});
  }
  return array;
}

json TrainingJson(const TrainingSummary& training) {
  return {
      {"steps", training.num_steps},
      {"resumed_steps", training.num_resumed_steps},
      {"stopped_early", training.stopped_early},
      {"steps_to_converge",
       training.num_steps_to_converge >= 0
           ? json(training.num_steps_to_converge)
           : json()},
      {"confirmed_share",
       training.confirmed_share >= 0 ? json(training.confirmed_share) : json()},
      {"final_loss", training.final_loss},
      {"held_out_psnr", training.held_out_psnr},
      {"seconds", training.seconds},
      {"rays", training.num_rays},
      {"samples", training.num_samples},
      {"samples_per_second", SamplesPerSecond(training)},
      {"parameters", training.num_parameters},
      {"guards", training.guard_counts}};
}

// "skipped_steps 2"; empty if none has acted.
std::string ActedGuards(const TrainingSummary& training) {
  std::string text;
  for (const auto& [name, count] : training.guard_counts) {
    if (count > 0) {
      text += (text.empty() ? "" : ", ") + name + " " + std::to_string(count);
    }
  }
  return text;
}

double Percent(const size_t part, const size_t whole) {
  return whole > 0 ? 100.0 * part / whole : 0.0;
}

}  // namespace

void StageTimer::Begin(const std::string& name) {
  End();
  stages_.push_back({name, 0, 0});
  begin_ = std::chrono::steady_clock::now();
  start_cpu_seconds_ = ProcessCpuSeconds();
  running_ = true;
}

void StageTimer::End() {
  if (running_) {
    // COLMAP's timer follows the system's clock, which may be set.
    stages_.back().seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_)
            .count();
    stages_.back().cpu_seconds = ProcessCpuSeconds() - start_cpu_seconds_;
    running_ = false;
  }
}

std::string ReportJson(const RunReport& report) {
  const Totals totals(report);
  const json object = {{"schema_version", kSchemaVersion},
                       {"versions",
                        {{"structnerf", STRUCTNERF_VERSION},
                         {"colmap", ColmapVersionInfo()},
                         {"opencv", CV_VERSION},
                         {"compiler", __VERSION__}}},
                       {"hardware",
                        {{"cpu", CpuModel()},
                         {"cores", std::thread::hardware_concurrency()},
                         {"memory_bytes", AvailableMemory()}}},
                       {"options", OptionsJson(report.options)},
                       {"scene",
                        {{"views", report.views.size()},
                         {"points", report.num_points3D},
                         {"training_image_size", report.training_image_size},
                         {"decisions", DecisionsJson(report.decisions)}}},
                       {"stages", StagesJson(report.stages)},
                       {"seconds", totals.seconds},
                       {"cpu_seconds", totals.cpu_seconds},
                       {"memory",
                        {{"limit_bytes", report.memory_limit},
                         {"expected_bytes", report.expected_memory},
                         {"peak_bytes", report.peak_memory}}},
                       {"training", TrainingJson(report.training)},
                       {"maps",
                        {{"pixels", totals.num_pixels},
                         {"photometric_pixels", totals.num_photometric},
                         {"plane_pixels", report.num_completed_pixels},
                         {"geometric_pixels", totals.num_geometric}}},
                       {"views", ViewsJson(report.views)},
                       {"fusion",
                        {{"min_num_pixels", report.fusion_min_num_pixels},
                         {"points", report.num_fused_points}}},
                       {"warnings", report.warnings}};
  // Image names need not be UTF-8.
  return JsonText(object);
}

std::string ReportText(const RunReport& report) {
  const Totals totals(report);
  std::string text;
  AppendF(&text,
          "Views             %zu\n"
          "Pixels with depth %zu of %zu (%.1f %%), %zu (%.1f %%) confirmed by "
          "other views\n"
          "Points fused      %zu (min_num_pixels %d)\n",
          report.views.size(),
          totals.num_photometric,
          totals.num_pixels,
          Percent(totals.num_photometric, totals.num_pixels),
          totals.num_geometric,
          Percent(totals.num_geometric, totals.num_pixels),
          report.num_fused_points,
          report.fusion_min_num_pixels);
  AppendF(&text,
          "Training          %d steps%s, %.2f M samples/s",
          report.training.num_steps,
          report.training.stopped_early                ? " (stopped early)"
          : report.training.num_steps_to_converge >= 0 ? " (converged)"
                                                       : "",
          1e-6 * SamplesPerSecond(report.training));
  if (!std::isnan(report.training.final_loss)) {
    AppendF(&text, ", loss %.4f", report.training.final_loss);
  }
  if (report.training.confirmed_share >= 0) {
    AppendF(&text,
            ", %.1f %% of the pixels confirmed after the first round",
            100 * report.training.confirmed_share);
  }
  if (report.training.held_out_psnr >= 0) {
    AppendF(&text, ", held-out PSNR %.2f dB", report.training.held_out_psnr);
  }
  text += "\n";
  const std::string guards = ActedGuards(report.training);
  if (!guards.empty()) {
    text += "Guards that acted " + guards + "\n";
  }
  AppendF(&text, "Time              %.1f s:", totals.seconds);
  for (const StageReport& stage : report.stages) {
    AppendF(&text, " %s %.1f s;", stage.name.c_str(), stage.seconds);
  }
  text.back() = '\n';
  AppendF(&text,
          "CPU time          %.1f s\n"
          "Peak memory       %.2f GB (expected %.2f GB, limit %.2f GB)\n",
          totals.cpu_seconds,
          report.peak_memory / kBytesPerGb,
          report.expected_memory / kBytesPerGb,
          report.memory_limit / kBytesPerGb);
  for (const std::string& warning : report.warnings) {
    text += "Warning           " + warning + "\n";
  }
  text += "Workspace         " + report.workspace_path + "\n";
  return text;
}

void WriteReport(const RunReport& report, const std::string& folder) {
  const std::filesystem::path path(folder);
  WriteTextFile((path / "report.json").string(), ReportJson(report));
  std::string text = ReportText(report) + "\nChosen for this scene:\n";
  for (const SceneDecision& decision : report.decisions) {
    text += "  " + decision.Text() + "\n";
  }
  WriteTextFile((path / "report.txt").string(), text);
}

}  // namespace structnerf
