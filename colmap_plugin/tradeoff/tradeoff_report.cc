#include "colmap_plugin/tradeoff/tradeoff_report.h"

#include "colmap_plugin/evaluation/html_page.h"
#include "colmap_plugin/evaluation/map_pictures.h"
#include "colmap_plugin/json_text.h"
#include "colmap_plugin/memory_budget.h"
#include "colmap_plugin/png_file.h"
#include "colmap_plugin/text_output.h"
#include "colmap_plugin/tradeoff/tradeoff_plot.h"

#include <algorithm>
#include <filesystem>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

using nlohmann::json;

std::string ErrorName(const TradeoffScene& scene) {
  switch (ErrorKind(scene)) {
    case TradeoffError::kTruth:
      return "pixels without depth or more than 5 cm off, %";
    case TradeoffError::kHeldOut:
      return "pixels of held-out photographs predicted wrongly, %";
    default:
      return "pixels that the other view does not confirm, %";
  }
}

std::string ErrorText(const TradeoffScene& scene) {
  switch (ErrorKind(scene)) {
    case TradeoffError::kTruth:
      return "The error is measured against ground truth: the share of pixels "
             "that have truth and no depth, or one that is more than 5 cm off "
             "in the scale of structure-from-motion. PSNR is that of one in "
             "256 pixels, which are kept out of the training.";
    case TradeoffError::kHeldOut:
      return "There was no ground truth. Of " +
             std::to_string(scene.test_every) +
             " photographs one was kept out, and the error is the share of "
             "its textured pixels that the other photographs and their depth "
             "maps predict wrongly: what is wrong on blank surfaces is not "
             "seen by it. PSNR is that of the field at these photographs.";
    default:
      return "There was no ground truth, and no photograph to be kept out. The "
             "error is the share of pixels whose depth the other view does not "
             "confirm: what is wrong in the same way in both is not seen by "
             "it. PSNR is that of one in 256 pixels, which are kept out of the "
             "training.";
  }
}

// Over all seeds.
double Mean(const std::vector<TradeoffMeasurement>& measurements,
            double TradeoffMeasurement::*value) {
  double sum = 0;
  for (const TradeoffMeasurement& measurement : measurements) {
    sum += measurement.*value;
  }
  return sum / static_cast<double>(measurements.size());
}

std::string HeldOutPsnrText(
    const std::vector<TradeoffMeasurement>& measurements) {
  const bool is_known = std::all_of(measurements.begin(),
                                    measurements.end(),
                                    [](const TradeoffMeasurement& measurement) {
                                      return measurement.held_out_psnr >= 0;
                                    });
  return is_known ? FormatNumber(
                        "%.2f",
                        Mean(measurements, &TradeoffMeasurement::held_out_psnr))
                  : "-";
}

size_t PeakBytes(const MeasuredSetting& setting) {
  size_t peak = 0;
  for (const TradeoffMeasurement& measurement : setting.measurements) {
    peak = std::max(peak, measurement.peak_bytes);
  }
  return peak;
}

std::string TradeoffJson(const TradeoffScene& scene,
                         const std::vector<MeasuredSetting>& settings,
                         const std::vector<bool>& is_on_front,
                         const std::string& advice) {
  json object = {{"schema_version", 1},
                 {"images", scene.image_path},
                 {"model", scene.input_path},
                 {"truth", scene.truth.path},
                 {"error", ErrorName(scene)},
                 {"advice", advice},
                 {"settings", json::array()}};
  for (size_t i = 0; i < settings.size(); ++i) {
    json runs = json::array();
    for (const TradeoffMeasurement& measurement : settings[i].measurements) {
      runs.push_back(
          {{"seconds", measurement.seconds},
           {"cpu_seconds", measurement.cpu_seconds},
           {"peak_bytes", measurement.peak_bytes},
           {"error", measurement.error},
           {"held_out_psnr",
            measurement.held_out_psnr < 0 ? json(nullptr)
                                          : json(measurement.held_out_psnr)}});
    }
    object["settings"].push_back({{"name", settings[i].setting.name},
                                  {"is_on_front", is_on_front[i] == true},
                                  {"runs", runs}});
  }
  return JsonText(object);
}

std::string TradeoffHtml(const TradeoffScene& scene,
                         const std::vector<MeasuredSetting>& settings,
                         const std::vector<TradeoffPoint>& points,
                         const std::vector<bool>& is_on_front,
                         const std::string& advice,
                         const cv::Mat3b& plot) {
  HtmlPage page("Speed against accuracy");
  page.AddParagraph(advice);
  page.AddParagraph(ErrorText(scene));
  page.AddMarkup(
      "<p><img style=\"max-width:100%\" alt=\"Plot of time "
      "against error\" src=\"" +
      PngDataUri(plot) + "\"></p>\n");
  page.AddParagraph(
      "Blue: the settings that no other one beats in both time and error. "
      "Bars: from the best to the worst seed.");
  std::vector<std::vector<std::string>> rows = {{"setting",
                                                 "wall time",
                                                 "CPU s",
                                                 "memory GB",
                                                 "error % (range of seeds)",
                                                 "held-out PSNR dB",
                                                 "seeds",
                                                 "on the front"}};
  std::vector<HtmlPicture> pictures;
  for (size_t i = 0; i < settings.size(); ++i) {
    const std::vector<TradeoffMeasurement>& measurements =
        settings[i].measurements;
    rows.push_back(
        {points[i].name,
         DurationText(points[i].seconds),
         FormatNumber("%.1f",
                      Mean(measurements, &TradeoffMeasurement::cpu_seconds)),
         FormatNumber(
             "%.2f", static_cast<double>(PeakBytes(settings[i])) / kBytesPerGb),
         FormatNumber("%.1f", 100 * points[i].error) + " (" +
             FormatNumber("%.1f", 100 * points[i].min_error) + " to " +
             FormatNumber("%.1f", 100 * points[i].max_error) + ")",
         HeldOutPsnrText(measurements),
         std::to_string(measurements.size()),
         is_on_front[i] ? "yes" : "no"});
    const cv::Mat3b picture =
        cv::imread(TradeoffPicturePath(scene, settings[i].setting, /*seed=*/0));
    if (!picture.empty()) {
      pictures.push_back({points[i].name,
                          "Depth map with " + points[i].name,
                          PngDataUri(picture)});
    }
  }
  page.AddTable(rows);
  page.AddHeading("One view");
  page.AddParagraph(
      "Depth from near (dark) to far (bright); grey where there is none.");
  page.AddPictures(pictures);
  return page.Finish();
}

}  // namespace

TradeoffPoint MeasuredSetting::Point() const {
  TradeoffPoint point;
  point.name = setting.name;
  point.min_error = 1;
  point.seconds = Mean(measurements, &TradeoffMeasurement::seconds);
  point.error = Mean(measurements, &TradeoffMeasurement::error);
  for (const TradeoffMeasurement& measurement : measurements) {
    point.min_error = std::min(point.min_error, measurement.error);
    point.max_error = std::max(point.max_error, measurement.error);
  }
  return point;
}

std::string WriteTradeoffReport(const TradeoffScene& scene,
                                const std::vector<MeasuredSetting>& settings) {
  std::vector<TradeoffPoint> points;
  for (const MeasuredSetting& setting : settings) {
    points.push_back(setting.Point());
  }
  const std::vector<bool> is_on_front = FindParetoFront(points);
  const std::string advice = TradeoffAdvice(points);
  const cv::Mat3b plot = PlotTradeoff(points, ErrorName(scene));
  const fs::path folder(scene.output_path);
  WritePng((folder / "tradeoff.png").string(), plot);
  WriteTextFile((folder / "tradeoff.json").string(),
                TradeoffJson(scene, settings, is_on_front, advice));
  WriteTextFile(
      (folder / "tradeoff.html").string(),
      TradeoffHtml(scene, settings, points, is_on_front, advice, plot));
  return advice;
}

}  // namespace structnerf
