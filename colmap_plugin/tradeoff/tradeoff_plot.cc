#include "colmap_plugin/tradeoff/tradeoff_plot.h"

#include "colmap_plugin/text_output.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace structnerf {
namespace {

constexpr int kWidth = 960;
constexpr int kHeight = 560;
constexpr int kLeft = 70;
constexpr int kRight = 40;
constexpr int kTop = 50;
constexpr int kBottom = 60;

constexpr int kNumErrorTicks = 5;

// Dark on white, and told apart by any eye.
const cv::Scalar kWhite(255, 255, 255);
const cv::Scalar kBlack(40, 40, 40);
const cv::Scalar kGrey(215, 215, 215);
const cv::Scalar kFront(178, 114, 0);  // blue
const cv::Scalar kOther(0, 94, 213);   // vermilion

void PutText(const std::string& text,
             const cv::Point& at,
             const cv::Scalar& color,
             cv::Mat3b* plot) {
  cv::putText(
      *plot, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.5, color, 1, cv::LINE_AA);
}

// 1, 2, 5, 10, ... seconds.
std::vector<double> TimeTicks() {
  std::vector<double> ticks;
  for (double decade = 0.001; decade < 1e9; decade *= 10) {
    for (const int digit : {1, 2, 5}) {
      ticks.push_back(decade * digit);
    }
  }
  return ticks;
}

class Axes {
 public:
  explicit Axes(const std::vector<TradeoffPoint>& points) {
    double max_error = 0;
    double min_error = 1;
    min_log_ = std::log(points[0].seconds);
    max_log_ = min_log_;
    for (const TradeoffPoint& point : points) {
      min_log_ = std::min(min_log_, std::log(point.seconds));
      max_log_ = std::max(max_log_, std::log(point.seconds));
      min_error = std::min(min_error, point.min_error);
      max_error = std::max(max_error, point.max_error);
    }
    // Room for names, and for what is the same everywhere.
    max_log_ += 0.35 * (max_log_ - min_log_) + 0.2;
    min_log_ -= 0.1;
    // From tick to tick, so that there are two at least.
    double first = min_log_;
    double last = max_log_;
    for (const double seconds : TimeTicks()) {
      const double tick = std::log(seconds);
      if (tick <= min_log_) {
        first = tick;
      }
      if (tick >= max_log_) {
        last = tick;
        break;
      }
    }
    min_log_ = first;
    max_log_ = last;
    const double margin = 0.1 * (max_error - min_error) + 0.005;
    min_error_ = std::max(0.0, min_error - margin);
    max_error_ = std::min(1.0, max_error + margin);
  }

  cv::Point At(const double seconds, const double error) const {
    const double x = (std::log(seconds) - min_log_) / (max_log_ - min_log_);
    const double y = (error - min_error_) / (max_error_ - min_error_);
    return {kLeft + cvRound(x * (kWidth - kLeft - kRight)),
            kHeight - kBottom - cvRound(y * (kHeight - kTop - kBottom))};
  }

  void Draw(const std::string& error_name, cv::Mat3b* plot) const {
    for (int i = 0; i <= kNumErrorTicks; ++i) {
      const double error =
          min_error_ + (max_error_ - min_error_) * i / kNumErrorTicks;
      const cv::Point left = At(std::exp(min_log_), error);
      cv::line(*plot, left, At(std::exp(max_log_), error), kGrey);
      PutText(
          FormatNumber("%.1f", 100 * error), {10, left.y + 5}, kBlack, plot);
    }
    for (const double seconds : TimeTicks()) {
      if (std::log(seconds) < min_log_ || std::log(seconds) > max_log_) {
        continue;
      }
      const cv::Point bottom = At(seconds, min_error_);
      cv::line(*plot, bottom, At(seconds, max_error_), kGrey);
      PutText(
          seconds < 1 ? FormatNumber("%g s", seconds) : DurationText(seconds),
          {bottom.x - 15, bottom.y + 20},
          kBlack,
          plot);
    }
    PutText(error_name, {10, 25}, kBlack, plot);
    PutText("wall time", {kWidth - 110, kHeight - 15}, kBlack, plot);
  }

 private:
  double min_log_;
  double max_log_;
  double min_error_;
  double max_error_;
};

}  // namespace

cv::Mat3b PlotTradeoff(const std::vector<TradeoffPoint>& points,
                       const std::string& error_name) {
  cv::Mat3b plot(kHeight, kWidth);
  plot.setTo(kWhite);
  const Axes axes(points);
  axes.Draw(error_name, &plot);

  const std::vector<bool> is_on_front = FindParetoFront(points);
  std::vector<const TradeoffPoint*> front;
  for (size_t i = 0; i < points.size(); ++i) {
    if (is_on_front[i]) {
      front.push_back(&points[i]);
    }
  }
  std::sort(front.begin(), front.end(), [](const auto* a, const auto* b) {
    return a->seconds < b->seconds;
  });
  for (size_t i = 1; i < front.size(); ++i) {
    cv::line(plot,
             axes.At(front[i - 1]->seconds, front[i - 1]->error),
             axes.At(front[i]->seconds, front[i]->error),
             kFront,
             2,
             cv::LINE_AA);
  }
  for (size_t i = 0; i < points.size(); ++i) {
    const TradeoffPoint& point = points[i];
    const cv::Scalar& color = is_on_front[i] ? kFront : kOther;
    const cv::Point center = axes.At(point.seconds, point.error);
    cv::line(plot,
             axes.At(point.seconds, point.min_error),
             axes.At(point.seconds, point.max_error),
             color,
             2);
    cv::circle(plot, center, 5, color, cv::FILLED, cv::LINE_AA);
    PutText(point.name, {center.x + 9, center.y - 7}, kBlack, &plot);
  }
  return plot;
}

}  // namespace structnerf
