// Images of few pixels and of little content. Formats and sizes of files are in
// the cases of the program.

#include "tests/nerf/plane_scene.h"
#include "tests/stability/room_run.h"
#include "tests/stability/stability_case.h"

#include <algorithm>
#include <string>
#include <vector>

namespace structnerf {
namespace {

// The photographs of the room reduced by averaging; its cameras keep their
// size.
Scene WithImagesOf(const int width, const int height) {
  Scene scene = StabilityScene();
  for (View& view : scene.views) {
    const RgbImage full = view.image;
    view.image = PlainImage(width, height, 0);
    for (int row = 0; row < height; ++row) {
      for (int col = 0; col < width; ++col) {
        for (int c = 0; c < 3; ++c) {
          int sum = 0;
          int count = 0;
          for (int y = row * full.height / height;
               y < (row + 1) * full.height / height;
               ++y) {
            for (int x = col * full.width / width;
                 x < (col + 1) * full.width / width;
                 ++x) {
              sum +=
                  full.data[3 * (static_cast<size_t>(y) * full.width + x) + c];
              ++count;
            }
          }
          view.image.data[3 * (static_cast<size_t>(row) * width + col) + c] =
              static_cast<uint8_t>(sum / count);
        }
      }
    }
  }
  return scene;
}

// `change` turns red, green, blue of a pixel into others.
template <typename Change>
Scene WithPixels(const Change& change) {
  Scene scene = StabilityScene();
  for (size_t v = 0; v < scene.views.size(); ++v) {
    std::vector<uint8_t>& data = scene.views[v].image.data;
    for (size_t i = 0; i < data.size(); i += 3) {
      change(v, &data[i]);
    }
  }
  return scene;
}

std::string MeasurePixels(void (*change)(size_t view, uint8_t* rgb),
                          const double max_error) {
  return MeasureScene(WithPixels(change), StabilityOptions(), max_error);
}

}  // namespace

std::vector<StabilityCase> ImageCases() {
  // What interpolated points alone could give: no pixel says anything.
  constexpr double kPointsOnly = 40;
  constexpr double kAsGood = 15;
  // The colours of the views cannot all be right.
  constexpr double kContradiction = 70;
  std::vector<StabilityCase> cases;
  cases.push_back({"images of 16x16", [] {
                     return MeasureScene(
                         WithImagesOf(16, 16), StabilityOptions(), kPointsOnly);
                   }});
  cases.push_back({"images of 1x1",
                   [] {
                     ReconstructionOptions options = StabilityOptions();
                     options.training.num_steps = 400;
                     RunScene(WithImagesOf(1, 1), options);
                     return std::string();
                   },
                   "raise max_image_size"});
  cases.push_back({"images of 1x1, no patches", [] {
                     ReconstructionOptions options = StabilityOptions();
                     options.loss.patch_weight = 0;
                     return MeasureScene(
                         WithImagesOf(1, 1), options, kPointsOnly);
                   }});
  cases.push_back({"all images black", [] {
                     return MeasurePixels(
                         [](size_t, uint8_t* rgb) { std::fill_n(rgb, 3, 0); },
                         kPointsOnly);
                   }});
  cases.push_back({"all images white", [] {
                     return MeasurePixels(
                         [](size_t, uint8_t* rgb) { std::fill_n(rgb, 3, 255); },
                         kPointsOnly);
                   }});
  cases.push_back({"each image of another single colour", [] {
                     return MeasurePixels(
                         [](const size_t view, uint8_t* rgb) {
                           rgb[0] = static_cast<uint8_t>(40 * view);
                           rgb[1] = 90;
                           rgb[2] = static_cast<uint8_t>(255 - 40 * view);
                         },
                         kContradiction);
                   }});
  cases.push_back({"one black image among others", [] {
                     return MeasurePixels(
                         [](const size_t view, uint8_t* rgb) {
                           if (view == 2) {
                             std::fill_n(rgb, 3, 0);
                           }
                         },
                         kAsGood);
                   }});
  cases.push_back({"grey images", [] {
                     return MeasurePixels(
                         [](size_t, uint8_t* rgb) { rgb[0] = rgb[2] = rgb[1]; },
                         kAsGood);
                   }});
  cases.push_back({"images of black and white only", [] {
                     return MeasurePixels(
                         [](size_t, uint8_t* rgb) {
                           std::fill_n(rgb, 3, rgb[1] > 110 ? 255 : 0);
                         },
                         kPointsOnly);
                   }});
  return cases;
}

}  // namespace structnerf
