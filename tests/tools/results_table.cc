#include "tests/support/json_file.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using nlohmann::json;

constexpr char kUsage[] =
    "structnerf_results_table RUNS_FOLDER METHOD...\n"
    "Prints a table of methods x scenes. RUNS_FOLDER/SCENE/METHOD/SEED holds\n"
    "eval.json of structnerf_eval, report.json of the run behind it and, if a\n"
    "part of the scene is of interest, part.json of structnerf_eval on it.\n"
    "Shown is the mean over the seeds, and how far they are apart (half of\n"
    "the range). Methods are shown in the order given.\n";

// A column: where a number is in the two files, and how it is shown.
struct Metric {
  const char* name;
  json::json_pointer place;
  const char* format;
  double factor;
  bool more_is_better;
};

const std::vector<Metric>& Metrics() {
  using Place = json::json_pointer;
  static const std::vector<Metric> metrics = {
      {"PSNR dB", Place("/eval/held_out/psnr"), "%.2f", 1, true},
      {"SSIM", Place("/eval/held_out/ssim"), "%.3f", 1, true},
      {"LPIPS", Place("/eval/held_out/lpips"), "%.3f", 1, false},
      {"held-out depth RMSE m",
       Place("/eval/held_out/depth/image_scale/all/rmse_m"),
       "%.3f",
       1,
       false},
      {"plane mean dev. cm",
       Place("/eval/held_out/depth/planes/mean_deviation_m"),
       "%.2f",
       100,
       false},
      {"maps < 5 cm %",
       Place("/eval/maps/photometric/sfm_scale/all/within_5cm"),
       "%.1f",
       100,
       true},
      {"untextured < 5 cm %",
       Place("/eval/maps/photometric/sfm_scale/untextured/within_5cm"),
       "%.1f",
       100,
       true},
      {"part < 5 cm %",
       Place("/part/maps/photometric/sfm_scale/all/within_5cm"),
       "%.1f",
       100,
       true},
      {"cloud F 5 cm %", Place("/eval/cloud/f_5cm"), "%.1f", 100, true},
      {"CPU s", Place("/report/cpu_seconds"), "%.0f", 1, false}};
  return metrics;
}

// Mean and half of the range over the runs of one method on one scene.
struct Cell {
  double mean = 0;
  double spread = 0;
};

struct Row {
  std::string method;
  size_t num_runs = 0;

  // One per metric. A mean over some of the runs only would be of other runs
  // than its neighbours: it is none, though it was measured.
  std::vector<std::optional<Cell>> cells;
  std::vector<bool> is_measured;
};

std::vector<fs::path> SortedEntries(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder)) {
    paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::vector<double> ValuesOf(const std::vector<json>& runs,
                             const Metric& metric) {
  std::vector<double> values;
  for (const json& run : runs) {
    if (run.contains(metric.place) && run[metric.place].is_number()) {
      values.push_back(metric.factor * run[metric.place].get<double>());
    }
  }
  return values;
}

Cell MakeCell(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {std::accumulate(values.begin(), values.end(), 0.0) /
              static_cast<double>(values.size()),
          0.5 * (*high - *low)};
}

std::vector<json> ReadRuns(const fs::path& method_path) {
  std::vector<json> runs;
  if (fs::is_directory(method_path)) {
    for (const fs::path& run_path : SortedEntries(method_path)) {
      json& run = runs.emplace_back();
      run["eval"] = ReadJson(run_path / "eval.json");
      run["report"] = ReadJson(run_path / "report.json");
      if (fs::exists(run_path / "part.json")) {
        run["part"] = ReadJson(run_path / "part.json");
      }
    }
  }
  return runs;
}

// Methods that were not run on the scene have no row.
std::vector<Row> ReadScene(const fs::path& folder,
                           const std::vector<std::string>& methods) {
  std::vector<Row> rows;
  for (const std::string& method : methods) {
    const std::vector<json> runs = ReadRuns(folder / method);
    if (runs.empty()) {
      continue;
    }
    Row& row = rows.emplace_back();
    row.method = method;
    row.num_runs = runs.size();
    for (const Metric& metric : Metrics()) {
      const std::vector<double> values = ValuesOf(runs, metric);
      row.is_measured.push_back(!values.empty());
      row.cells.push_back(values.size() == runs.size()
                              ? std::optional<Cell>(MakeCell(values))
                              : std::nullopt);
    }
  }
  return rows;
}

// Metrics that some run of some scene has.
std::vector<bool> UsedMetrics(
    const std::map<std::string, std::vector<Row>>& scenes) {
  std::vector<bool> used(Metrics().size(), false);
  for (const auto& entry : scenes) {
    for (const Row& row : entry.second) {
      for (size_t i = 0; i < used.size(); ++i) {
        used[i] = used[i] || row.is_measured[i];
      }
    }
  }
  return used;
}

bool IsBest(const std::vector<Row>& rows,
            const size_t row_idx,
            const size_t metric_idx) {
  const double sign = Metrics()[metric_idx].more_is_better ? 1 : -1;
  const auto& cell = rows[row_idx].cells[metric_idx];
  return cell && std::all_of(rows.begin(), rows.end(), [&](const Row& other) {
           return !other.cells[metric_idx] ||
                  sign * other.cells[metric_idx]->mean <= sign * cell->mean;
         });
}

std::string CellText(const Cell& cell,
                     const Metric& metric,
                     const size_t num_runs,
                     const bool is_best) {
  char number[64];
  snprintf(number, sizeof(number), metric.format, cell.mean);
  std::string text = is_best ? "**" + std::string(number) + "**" : number;
  if (num_runs > 1) {
    snprintf(number, sizeof(number), metric.format, cell.spread);
    text += " ± " + std::string(number);
  }
  return text;
}

void PrintTable(const std::map<std::string, std::vector<Row>>& scenes) {
  const std::vector<bool> used = UsedMetrics(scenes);
  std::string header = "| scene | method | runs |";
  std::string rule = "|---|---|--:|";
  for (size_t i = 0; i < used.size(); ++i) {
    if (used[i]) {
      header += std::string(" ") + Metrics()[i].name + " |";
      rule += "--:|";
    }
  }
  std::cout << header << "\n" << rule << "\n";
  for (const auto& [scene, rows] : scenes) {
    for (size_t r = 0; r < rows.size(); ++r) {
      std::cout << "| " << scene << " | " << rows[r].method << " | "
                << rows[r].num_runs << " |";
      for (size_t i = 0; i < used.size(); ++i) {
        if (used[i]) {
          std::cout << " "
                    << (rows[r].cells[i] ? CellText(*rows[r].cells[i],
                                                    Metrics()[i],
                                                    rows[r].num_runs,
                                                    IsBest(rows, r, i))
                                         : "-")
                    << " |";
        }
      }
      std::cout << "\n";
    }
  }
}

std::map<std::string, std::vector<Row>> ReadScenes(
    const std::string& runs_folder, const std::vector<std::string>& methods) {
  if (!fs::is_directory(runs_folder)) {
    throw std::runtime_error("The folder " + runs_folder + " does not exist.");
  }
  std::map<std::string, std::vector<Row>> scenes;
  for (const fs::path& scene_path : SortedEntries(runs_folder)) {
    std::vector<Row> rows = ReadScene(scene_path, methods);
    if (!rows.empty()) {
      scenes.emplace(scene_path.filename().string(), std::move(rows));
    }
  }
  if (scenes.empty()) {
    throw std::runtime_error(
        "The folder " + runs_folder +
        " has no runs SCENE/METHOD/SEED of these methods.");
  }
  return scenes;
}

int Main(const int argc, char** argv) {
  if (argc < 3) {
    std::cerr << kUsage;
    return EXIT_FAILURE;
  }
  try {
    PrintTable(ReadScenes(argv[1], {argv + 2, argv + argc}));
  } catch (const std::exception& error) {
    std::cerr << "ERROR: " << error.what() << std::endl;
    return EXIT_FAILURE;
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace structnerf

int main(int argc, char** argv) { return structnerf::Main(argc, argv); }
