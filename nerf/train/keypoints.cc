#include "nerf/train/keypoints.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace structnerf {
namespace {

constexpr int kBlock = 32;
constexpr int kCell = 4;
constexpr float kMinExcess = 7.0f / 255.0f * TrainingViews::kMaxGray;

// Length of the gradient, in units of grey values per pixel; 0 = none.
std::vector<float> GradientMagnitudes(const TrainingViews& views,
                                      const int view_idx) {
  const TrainingViews::Image& image = views.image(view_idx);
  const uint16_t* const grays = views.Grays() + image.first_pixel;
  std::vector<float> magnitudes(static_cast<size_t>(image.width) * image.height,
                                0.0f);
  for (int row = 1; row + 1 < image.height; ++row) {
    for (int col = 1; col + 1 < image.width; ++col) {
      const size_t i = static_cast<size_t>(row) * image.width + col;
      const uint16_t neighbors[] = {grays[i - 1],
                                    grays[i + 1],
                                    grays[i - image.width],
                                    grays[i + image.width],
                                    grays[i]};
      if (std::count(std::begin(neighbors),
                     std::end(neighbors),
                     TrainingViews::kMaskedGray) == 0) {
        magnitudes[i] = 0.5f * std::hypot(static_cast<float>(neighbors[1]) -
                                              static_cast<float>(neighbors[0]),
                                          static_cast<float>(neighbors[3]) -
                                              static_cast<float>(neighbors[2]));
      }
    }
  }
  return magnitudes;
}

// Pixels [left, right) x [top, bottom).
struct Window {
  int left = 0;
  int top = 0;
  int right = 0;
  int bottom = 0;
};

// Calls visit(window) for the squares of `size` pixels that `whole` is cut
// into; those at its right and lower end are smaller.
template <typename Visit>
void ForEachSquare(const Window& whole, const int size, const Visit& visit) {
  for (int top = whole.top; top < whole.bottom; top += size) {
    for (int left = whole.left; left < whole.right; left += size) {
      visit(Window{left,
                   top,
                   std::min(left + size, whole.right),
                   std::min(top + size, whole.bottom)});
    }
  }
}

// Pixels of a window, row * width + col.
std::vector<uint32_t> PixelsOf(const Window& window, const int width) {
  std::vector<uint32_t> pixels;
  for (int row = window.top; row < window.bottom; ++row) {
    for (int col = window.left; col < window.right; ++col) {
      pixels.push_back(static_cast<uint32_t>(row * width + col));
    }
  }
  return pixels;
}

}  // namespace

std::vector<uint32_t> SelectKeypoints(const TrainingViews& views,
                                      const int view_idx) {
  const TrainingViews::Image& image = views.image(view_idx);
  const std::vector<float> magnitudes = GradientMagnitudes(views, view_idx);
  const auto is_weaker = [&](const uint32_t a, const uint32_t b) {
    return magnitudes[a] < magnitudes[b];
  };
  std::vector<uint32_t> keypoints;
  const Window whole = {0, 0, image.width, image.height};
  ForEachSquare(whole, kBlock, [&](const Window& block) {
    std::vector<uint32_t> pixels = PixelsOf(block, image.width);
    const auto middle = pixels.begin() + pixels.size() / 2;
    std::nth_element(pixels.begin(), middle, pixels.end(), is_weaker);
    const float threshold = magnitudes[*middle] + kMinExcess;
    ForEachSquare(block, kCell, [&](const Window& cell) {
      const std::vector<uint32_t> candidates = PixelsOf(cell, image.width);
      const uint32_t strongest =
          *std::max_element(candidates.begin(), candidates.end(), is_weaker);
      if (magnitudes[strongest] > threshold) {
        keypoints.push_back(strongest);
      }
    });
  });
  return keypoints;
}

}  // namespace structnerf
