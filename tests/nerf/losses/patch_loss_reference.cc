#include "tests/nerf/losses/patch_loss_reference.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

namespace structnerf {
namespace {

// Grey value of a pixel in [0, 1]; nothing outside the image or if masked.
std::optional<double> Gray(const View& view, const int col, const int row) {
  if (col < 0 || row < 0 || col >= view.image.width ||
      row >= view.image.height) {
    return std::nullopt;
  }
  const size_t pixel = static_cast<size_t>(row) * view.image.width + col;
  if (!view.mask.empty() && view.mask[pixel] == 0) {
    return std::nullopt;
  }
  const uint8_t* const rgb = view.image.data.data() + 3 * pixel;
  return (0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2]) / 255.0;
}

std::optional<double> Bilinear(const View& view, const double x, double y) {
  const double col = std::floor(x - 0.5);
  const double row = std::floor(y - 0.5);
  const double shares[2][2] = {{1 - (x - 0.5 - col), x - 0.5 - col},
                               {1 - (y - 0.5 - row), y - 0.5 - row}};
  double sum = 0;
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      const std::optional<double> gray =
          Gray(view, static_cast<int>(col) + dx, static_cast<int>(row) + dy);
      if (!gray) {
        return std::nullopt;
      }
      sum += shares[0][dx] * shares[1][dy] * *gray;
    }
  }
  return sum;
}

}  // namespace

std::optional<double> ReferencePatchLoss(const Scene& scene,
                                         const PatchLoss::Options& options,
                                         const int view_idx,
                                         const int source_idx,
                                         const int col,
                                         const int row,
                                         const double depth) {
  const View& view = scene.views[view_idx];
  const View& source = scene.views[source_idx];
  const Eigen::Matrix3d inverse_k =
      view.ImageCamera().CalibrationMatrix().inverse();
  // At the border the patch moves inside.
  const int reach = options.radius * options.dilation;
  const int center_col =
      std::max(std::min(col, view.image.width - 1 - reach), reach);
  const int center_row =
      std::max(std::min(row, view.image.height - 1 - reach), reach);
  std::vector<double> a;
  std::vector<double> b;
  for (int dy = -options.radius; dy <= options.radius; ++dy) {
    for (int dx = -options.radius; dx <= options.radius; ++dx) {
      const int tap_col = center_col + dx * options.dilation;
      const int tap_row = center_row + dy * options.dilation;
      const Eigen::Vector3d in_view =
          depth * inverse_k * Eigen::Vector3d(tap_col + 0.5, tap_row + 0.5, 1);
      const Eigen::Vector3d in_source =
          source.CamFromWorld(view.WorldFromCam(in_view));
      if (in_source.z() <= 0.02 * depth) {
        return std::nullopt;
      }
      const Eigen::Vector3d pixel =
          source.ImageCamera().CalibrationMatrix() * in_source / in_source.z();
      const std::optional<double> own = Gray(view, tap_col, tap_row);
      const std::optional<double> other =
          Bilinear(source, pixel.x(), pixel.y());
      if (!own || !other) {
        return std::nullopt;
      }
      a.push_back(*own);
      b.push_back(*other);
    }
  }
  const double n = static_cast<double>(a.size());
  double mean_a = 0, mean_b = 0, absolute = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    mean_a += a[i] / n;
    mean_b += b[i] / n;
    absolute += std::abs(a[i] - b[i]) / n;
  }
  double variance_a = 0, variance_b = 0, covariance = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    variance_a += (a[i] - mean_a) * (a[i] - mean_a) / n;
    variance_b += (b[i] - mean_b) * (b[i] - mean_b) / n;
    covariance += (a[i] - mean_a) * (b[i] - mean_b) / n;
  }
  const double ssim = (2 * mean_a * mean_b + 1e-4) * (2 * covariance + 9e-4) /
                      ((mean_a * mean_a + mean_b * mean_b + 1e-4) *
                       (variance_a + variance_b + 9e-4));
  return options.ssim_share * (1 - ssim) / 2 +
         (1 - options.ssim_share) * absolute;
}

std::optional<double> ReferencePatchLoss(const Scene& scene,
                                         const PatchLoss::Options& options,
                                         const int view_idx,
                                         const std::vector<int>& source_idxs,
                                         const int col,
                                         const int row,
                                         const double depth) {
  std::vector<double> losses;
  for (const int source_idx : source_idxs) {
    const std::optional<double> loss = ReferencePatchLoss(
        scene, options, view_idx, source_idx, col, row, depth);
    if (loss) {
      losses.push_back(*loss);
    }
  }
  if (losses.empty()) {
    return std::nullopt;
  }
  std::sort(losses.begin(), losses.end());
  losses.resize(std::min(losses.size(), static_cast<size_t>(options.num_best)));
  double sum = 0;
  for (const double loss : losses) {
    sum += loss;
  }
  return sum / static_cast<double>(losses.size());
}

}  // namespace structnerf
