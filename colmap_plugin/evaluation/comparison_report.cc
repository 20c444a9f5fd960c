#include "colmap_plugin/evaluation/comparison_report.h"

#include "colmap_plugin/evaluation/evaluation_report.h"
#include "colmap_plugin/json_text.h"
#include "colmap_plugin/text_output.h"

#include <filesystem>
#include <functional>

#include <nlohmann/json.hpp>

namespace structnerf {
namespace {

using nlohmann::json;

// Raised when a field changes its name or meaning.
constexpr int kSchemaVersion = 1;

constexpr const char* kUnknown = "-";

template <typename Value>
json OptionalJson(const std::optional<Value>& value) {
  return value ? json(*value) : json(nullptr);
}

json AgreementJson(const MapAgreement& agreement) {
  json object = {{"common_pixels", agreement.num_common},
                 {"median_relative_difference",
                  agreement.num_common > 0 ? json(agreement.median_difference)
                                           : json(nullptr)}};
  for (size_t i = 0; i < kAgreementThresholds.size(); ++i) {
    object[FormatNumber("within_%g%%", 100 * kAgreementThresholds[i])] =
        agreement.shares[i];
  }
  return object;
}

json WorkspaceJson(const ComparedWorkspace& workspace) {
  json object = {{"path", workspace.path},
                 {"map_type", MapTypeName(workspace.map_type)},
                 {"views", workspace.num_views},
                 {"coverage", workspace.coverage},
                 {"fused_points", OptionalJson(workspace.num_fused_points)},
                 {"seconds", OptionalJson(workspace.seconds)},
                 {"cpu_seconds", OptionalJson(workspace.cpu_seconds)}};
  if (workspace.evaluation) {
    object["evaluation"] = json::parse(EvaluationJson(*workspace.evaluation));
  }
  return object;
}

// What the evaluation says about the maps that are compared, or null.
const SplitDepthMetrics* MetricsOf(const ComparedWorkspace& workspace) {
  if (!workspace.evaluation) {
    return nullptr;
  }
  const auto maps =
      workspace.evaluation->maps.find(MapTypeName(workspace.map_type));
  if (maps == workspace.evaluation->maps.end() ||
      !maps->second.depth.in_sfm_scale) {
    return nullptr;
  }
  return &*maps->second.depth.in_sfm_scale;
}

class RowMaker {
 public:
  explicit RowMaker(const Comparison& comparison) : comparison_(comparison) {}

  void Add(const std::string& name,
           const std::function<std::string(const ComparedWorkspace&)>& value) {
    rows_.push_back(
        {name,
         {value(comparison_.workspaces[0]), value(comparison_.workspaces[1])}});
  }

  // The value may be unknown.
  void AddMetric(
      const std::string& name,
      const char* format,
      const std::function<std::optional<double>(const SplitDepthMetrics&)>&
          value) {
    Add(name, [&](const ComparedWorkspace& workspace) {
      const SplitDepthMetrics* metrics = MetricsOf(workspace);
      const std::optional<double> known =
          metrics == nullptr ? std::nullopt : value(*metrics);
      return known ? FormatNumber(format, *known) : std::string(kUnknown);
    });
  }

  std::vector<ComparisonRow> Take() { return std::move(rows_); }

 private:
  const Comparison& comparison_;
  std::vector<ComparisonRow> rows_;
};

void AddTruthRows(RowMaker* rows) {
  const auto percent_within = [&](const std::string& name,
                                  const size_t threshold_idx,
                                  DepthMetrics SplitDepthMetrics::*part) {
    rows->AddMetric(name, "%.1f", [=](const SplitDepthMetrics& metrics) {
      return 100 * (metrics.*part).within[threshold_idx];
    });
  };
  percent_within("Within 2 cm of the truth, % of all pixels with truth",
                 0,
                 &SplitDepthMetrics::all);
  percent_within("Within 5 cm, %", 1, &SplitDepthMetrics::all);
  percent_within("Within 10 cm, %", 2, &SplitDepthMetrics::all);
  percent_within(
      "Within 5 cm, % of the textured ones", 1, &SplitDepthMetrics::textured);
  percent_within("Within 5 cm, % of the untextured ones",
                 1,
                 &SplitDepthMetrics::untextured);
  const auto error = [&](const std::string& name,
                         const char* format,
                         const double factor,
                         double DepthMetrics::*part) {
    rows->AddMetric(
        name,
        format,
        [=](const SplitDepthMetrics& metrics) -> std::optional<double> {
          if (metrics.all.num_predictions == 0) {
            return std::nullopt;
          }
          return factor * metrics.all.*part;
        });
  };
  error("Median error, cm, where there is depth",
        "%.2f",
        100,
        &DepthMetrics::median_error);
  error("RMSE, m, where there is depth", "%.3f", 1, &DepthMetrics::rmse);
  rows->Add(
      "F-score of the cloud at 5 cm, %",
      [](const ComparedWorkspace& workspace) {
        return workspace.evaluation->cloud
                   ? FormatNumber(
                         "%.1f",
                         100 * workspace.evaluation->cloud->metrics.f_score[1])
                   : std::string(kUnknown);
      });
}

}  // namespace

std::vector<ComparisonRow> ComparisonRows(const Comparison& comparison) {
  RowMaker rows(comparison);
  rows.Add("Workspace",
           [](const ComparedWorkspace& workspace) { return workspace.path; });
  rows.Add("Maps", [](const ComparedWorkspace& workspace) {
    return MapTypeName(workspace.map_type);
  });
  rows.Add("Views", [](const ComparedWorkspace& workspace) {
    return std::to_string(workspace.num_views);
  });
  rows.Add("Pixels with depth, %", [](const ComparedWorkspace& workspace) {
    return FormatNumber("%.1f", 100 * workspace.coverage);
  });
  rows.Add("Fused points", [](const ComparedWorkspace& workspace) {
    return workspace.num_fused_points
               ? std::to_string(*workspace.num_fused_points)
               : std::string(kUnknown);
  });
  const auto seconds_text = [](const std::optional<double>& seconds) {
    return seconds ? FormatNumber("%.1f", *seconds) : std::string(kUnknown);
  };
  rows.Add("Time, s", [&](const ComparedWorkspace& workspace) {
    return seconds_text(workspace.seconds);
  });
  rows.Add("CPU time, s", [&](const ComparedWorkspace& workspace) {
    return seconds_text(workspace.cpu_seconds);
  });
  if (!comparison.options.truth.path.empty()) {
    AddTruthRows(&rows);
  }
  return rows.Take();
}

std::string ComparisonJson(const Comparison& comparison) {
  json views = json::array();
  for (const ViewComparison& view : comparison.views) {
    views.push_back({{"name", view.name},
                     {"coverage", view.coverage},
                     {"median_error_m",
                      {OptionalJson(view.median_error[0]),
                       OptionalJson(view.median_error[1])}},
                     {"agreement", AgreementJson(view.agreement)}});
  }
  const json object = {{"schema_version", kSchemaVersion},
                       {"workspaces",
                        {WorkspaceJson(comparison.workspaces[0]),
                         WorkspaceJson(comparison.workspaces[1])}},
                       {"a_units_per_b_unit", comparison.a_per_b},
                       {"agreement", AgreementJson(comparison.agreement)},
                       {"views", std::move(views)},
                       {"notes", comparison.notes}};
  return JsonText(object);
}

std::string ComparisonText(const Comparison& comparison) {
  std::string text;
  const auto append_row =
      [&](const std::string& name, const std::string& a, const std::string& b) {
        AppendF(&text, "%-54s %16s %16s\n", name.c_str(), a.c_str(), b.c_str());
      };
  append_row("", "A", "B");
  for (const ComparisonRow& row : ComparisonRows(comparison)) {
    if (row.name == "Workspace") {
      continue;  // paths are as long as they like
    }
    append_row(row.name, row.values[0], row.values[1]);
  }
  text += "Agreement: " + AgreementText(comparison.agreement) + ".\n";
  for (const std::string& note : comparison.notes) {
    text += "Note: " + note + "\n";
  }
  return text;
}

std::string WriteComparison(const Comparison& comparison,
                            const std::string& folder) {
  const std::filesystem::path path(folder);
  std::error_code error;
  std::filesystem::create_directories(path, error);
  const std::string page_path = (path / "comparison.html").string();
  WriteTextFile((path / "comparison.json").string(),
                ComparisonJson(comparison));
  WriteTextFile(page_path, ComparisonHtml(comparison));
  return page_path;
}

std::string AgreementText(const MapAgreement& agreement) {
  if (agreement.num_common == 0) {
    return "no pixel where both have depth";
  }
  std::string text = "of the pixels where both have depth, ";
  for (size_t i = 0; i < kAgreementThresholds.size(); ++i) {
    AppendF(&text,
            "%.1f %% agree within %g %%, ",
            100 * agreement.shares[i],
            100 * kAgreementThresholds[i]);
  }
  AppendF(&text,
          "median difference %.2f %% of A's depth",
          100 * agreement.median_difference);
  return text;
}

}  // namespace structnerf
