#pragma once

#include "colmap_plugin/option_table.h"
#include "nerf/analysis/scene_decision.h"
#include "nerf/reconstructor.h"
#include "nerf/scene.h"

#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace structnerf {

// What a stage of the run cost.
struct StageReport {
  std::string name;
  double seconds = 0;      // wall time
  double cpu_seconds = 0;  // of all threads
};

struct ViewReport {
  std::string name;
  int width = 0;               // of the maps
  int height = 0;              // of the maps
  size_t num_photometric = 0;  // pixels given a depth
  size_t num_geometric = 0;    // of these, confirmed by other views
  Exposure exposure;
};

// All that is known about a run when it has ended.
struct RunReport {
  std::map<std::string, OptionValue> options;
  int num_points3D = 0;
  int training_image_size = 0;  // longest side in pixels
  std::vector<SceneDecision> decisions;
  std::vector<StageReport> stages;
  size_t memory_limit = 0;     // bytes
  size_t expected_memory = 0;  // bytes, planned before the start
  size_t peak_memory = 0;      // bytes
  TrainingSummary training;
  size_t num_completed_pixels = 0;  // put onto planes, of all views
  std::vector<ViewReport> views;
  int fusion_min_num_pixels = 0;
  size_t num_fused_points = 0;
  std::vector<std::string> warnings;
  std::string workspace_path;
};

// Times stages one after another.
class StageTimer {
 public:
  // Ends the stage before and begins one.
  void Begin(const std::string& name);
  void End();
  const std::vector<StageReport>& Stages() const { return stages_; }

 private:
  std::vector<StageReport> stages_;
  std::chrono::steady_clock::time_point begin_;
  double start_cpu_seconds_ = 0;
  bool running_ = false;
};

// A machine-readable form, with the versions and the hardware of this process.
std::string ReportJson(const RunReport& report);

// The short form for people: pixels, points, times and memory.
std::string ReportText(const RunReport& report);

// Writes report.json and report.txt into the folder. Throws std::runtime_error
// if that fails.
void WriteReport(const RunReport& report, const std::string& folder);

}  // namespace structnerf
