#include "nerf/losses/far_push.h"

#include <algorithm>
#include <cmath>

namespace structnerf {
namespace {

// Taps at offsets -kReach, -kReach + kStep, ..., kReach, as far as two patches
// of the paper.
constexpr int kReach = 4;
constexpr int kStep = 2;

constexpr float kMaxDeviation = 0.06f;

}  // namespace

std::vector<uint8_t> MeasureBlankness(const TrainingViews& views,
                                      const int view_idx) {
  const TrainingViews::Image& image = views.image(view_idx);
  const uint16_t* const grays = views.Grays() + image.first_pixel;
  std::vector<uint8_t> blankness(static_cast<size_t>(image.width) *
                                 image.height);
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      const size_t pixel = static_cast<size_t>(row) * image.width + col;
      if (grays[pixel] == TrainingViews::kMaskedGray) {
        continue;
      }
      // Relative to the centre, so that blank means exactly zero.
      float sum = 0;
      float sum_squares = 0;
      float count = 0;
      for (int dy = -kReach; dy <= kReach; dy += kStep) {
        const int y = std::clamp(row + dy, 0, image.height - 1);
        for (int dx = -kReach; dx <= kReach; dx += kStep) {
          const int x = std::clamp(col + dx, 0, image.width - 1);
          const uint16_t gray = grays[static_cast<size_t>(y) * image.width + x];
          if (gray == TrainingViews::kMaskedGray) {
            continue;
          }
          const float difference = (static_cast<float>(gray) - grays[pixel]) *
                                   (1.0f / TrainingViews::kMaxGray);
          sum += difference;
          sum_squares += difference * difference;
          ++count;
        }
      }
      const float mean = sum / count;
      const float deviation =
          std::sqrt(std::max(0.0f, sum_squares / count - mean * mean));
      blankness[pixel] = static_cast<uint8_t>(
          255.0f * std::max(0.0f, 1.0f - deviation / kMaxDeviation) + 0.5f);
    }
  }
  return blankness;
}

float EvaluateFarPush(const uint8_t blankness,
                      const float depth,
                      float* d_depth) {
  const float weight = static_cast<float>(blankness) * (1.0f / 255.0f);
  *d_depth = -weight / depth;
  return -weight * std::log(depth);
}

}  // namespace structnerf
