// Image files of all kinds, through the program as a user runs it.

#include "tests/colmap_plugin/tiny_model.h"
#include "tests/end_to_end/run_program.h"
#include "tests/stability/stability_case.h"
#include "tests/support/temp_dir.h"

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include <colmap/mvs/depth_map.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

// Runs on the images that `change` makes of 8-bit ones; they keep their size
// and have this extension. Throws the program's error.
std::string MeasureFiles(const int width,
                         const int height,
                         const std::string& extension,
                         const std::vector<std::string>& options,
                         const std::function<cv::Mat(const cv::Mat&)>& change) {
  const TempDir temp_dir;
  TinyModel model = MakeTinyModel(3);
  const double focal_length = 0.9 * std::max(width, height);
  model.cameras[0] = {"PINHOLE",
                      width,
                      height,
                      {focal_length, focal_length, 0.5 * width, 0.5 * height}};
  for (size_t i = 0; i < model.images.size(); ++i) {
    model.images[i].name = std::to_string(i) + extension;
  }
  model.WriteModel(temp_dir / "sparse/0");
  fs::create_directories(temp_dir / "images");
  for (size_t i = 0; i < model.images.size(); ++i) {
    // The plane z = 4 under a texture that moves with the camera.
    cv::Mat image(height, width, CV_8UC3);
    const double shift = focal_length * model.images[i].x / 4;
    const double wave = 0.02 * focal_length;
    for (int row = 0; row < height; ++row) {
      for (int col = 0; col < width; ++col) {
        const auto level = static_cast<uint8_t>(
            127 + 60 * std::sin((col + shift) / wave) +
            60 * std::sin(row / wave + 0.3 * (col + shift) / wave));
        image.at<cv::Vec3b>(row, col) = {level, level, level};
      }
    }
    if (!cv::imwrite(temp_dir / ("images/" + model.images[i].name),
                     change(image))) {
      throw UnstableError{"the test's own image cannot be written"};
    }
  }
  ProgramOptions program;
  program.arguments = {"structnerf_dense",
                       "--image_path",
                       temp_dir / "images",
                       "--input_path",
                       temp_dir / "sparse/0",
                       "--output_path",
                       temp_dir / "dense",
                       "--StructNeRF.quality=low",
                       "--StructNeRF.log2_table_size=12",
                       "--StructNeRF.num_steps=250"};
  program.arguments.insert(
      program.arguments.end(), options.begin(), options.end());
  const ProgramResult result = RunProgram(program);
  if (result.exit_code != EXIT_SUCCESS) {
    RequireStable(result.exit_code == EXIT_FAILURE,
                  "ended by signal " + std::to_string(result.signal));
    const size_t begin = result.error.rfind("ERROR: ");
    RequireStable(begin != std::string::npos, "no error is named");
    std::string text = result.error.substr(begin + 7);
    text.erase(text.find_last_not_of('\n') + 1);
    throw std::runtime_error(text);
  }
  colmap::mvs::DepthMap map;
  map.Read(temp_dir / ("dense/stereo/depth_maps/" + model.images[1].name +
                       ".photometric.bin"));
  RequireStable(static_cast<int>(map.GetWidth()) == width &&
                    static_cast<int>(map.GetHeight()) == height,
                "the map has a wrong size");
  size_t num_right = 0;
  for (const float depth : map.GetData()) {
    RequireStable(std::isfinite(depth) && depth >= 0, "a depth is not finite");
    num_right += std::abs(depth / 4 - 1) < 0.1;
  }
  return ShortNumber(100.0 * num_right / map.GetData().size()) +
         " % of the depths within 10 %";
}

cv::Mat Converted(const cv::Mat& image, const int type, const double scale) {
  cv::Mat converted;
  if (CV_MAT_CN(type) == 1) {
    cv::cvtColor(image, converted, cv::COLOR_BGR2GRAY);
  } else if (CV_MAT_CN(type) == 4) {
    cv::cvtColor(image, converted, cv::COLOR_BGR2BGRA);
  } else {
    converted = image;
  }
  converted.convertTo(converted, type, scale);
  return converted;
}

}  // namespace

std::vector<StabilityCase> ProgramCases() {
  const auto convert = [](const int type, const double scale) {
    return [=](const cv::Mat& image) { return Converted(image, type, scale); };
  };
  std::vector<StabilityCase> cases;
  const auto add = [&](const std::string& name,
                       const std::string& extension,
                       const int type,
                       const double scale,
                       const std::string& error = "") {
    cases.push_back({"program: " + name,
                     [=] {
                       return MeasureFiles(
                           64, 48, extension, {}, convert(type, scale));
                     },
                     error});
  };
  add("8-bit colour PNG", ".png", CV_8UC3, 1);
  add("8-bit grey PNG", ".png", CV_8UC1, 1);
  add("16-bit grey PNG",
      ".png",
      CV_16UC1,
      257,
      "8 bits per channel");  // COLMAP 4 can read them
  add("16-bit colour PNG", ".png", CV_16UC3, 257);
  add("PNG with transparency", ".png", CV_8UC4, 1);
  add("grey JPEG", ".jpg", CV_8UC1, 1);
  add("16-bit TIFF", ".tif", CV_16UC3, 257);
  cases.push_back(
      {"program: images of 16x16",
       [=] { return MeasureFiles(16, 16, ".png", {}, convert(CV_8UC3, 1)); }});
  cases.push_back({"program: images of 1000x10, reduced to 16x1",
                   [=] {
                     return MeasureFiles(1000,
                                         10,
                                         ".png",
                                         {"--StructNeRF.max_image_size=16"},
                                         convert(CV_8UC3, 1));
                   },
                   "raise max_image_size"});
  cases.push_back({"program: images of 8000x6000", [=] {
                     return MeasureFiles(
                         8000, 6000, ".jpg", {}, convert(CV_8UC3, 1));
                   }});
  cases.back().is_slow = true;
  return cases;
}

}  // namespace structnerf
