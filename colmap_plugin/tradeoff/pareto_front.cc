#include "colmap_plugin/tradeoff/pareto_front.h"

#include "colmap_plugin/text_output.h"

#include <algorithm>

namespace structnerf {
namespace {

// Repeated runs differ by as much.
constexpr double kMinDifference = 0.01;

bool Dominates(const TradeoffPoint& a, const TradeoffPoint& b) {
  return a.seconds <= b.seconds && a.error <= b.error &&
         (a.seconds < b.seconds || a.error < b.error);
}

std::string PercentPoints(const double difference) {
  return FormatNumber("%.1f %%", 100 * difference);
}

}  // namespace

std::vector<bool> FindParetoFront(const std::vector<TradeoffPoint>& points) {
  std::vector<bool> is_on_front;
  for (const TradeoffPoint& point : points) {
    is_on_front.push_back(std::none_of(
        points.begin(), points.end(), [&](const TradeoffPoint& other) {
          return Dominates(other, point);
        }));
  }
  return is_on_front;
}

std::string TradeoffAdvice(const std::vector<TradeoffPoint>& points) {
  const auto is_faster = [](const TradeoffPoint& a, const TradeoffPoint& b) {
    return a.seconds < b.seconds;
  };
  const TradeoffPoint& best =
      *std::min_element(points.begin(),
                        points.end(),
                        [](const TradeoffPoint& a, const TradeoffPoint& b) {
                          return a.error < b.error;
                        });
  const TradeoffPoint* choice = &best;
  const std::vector<bool> is_on_front = FindParetoFront(points);
  for (size_t i = 0; i < points.size(); ++i) {
    const TradeoffPoint& point = points[i];
    const double spread = std::max(point.max_error - point.min_error,
                                   best.max_error - best.min_error);
    if (is_on_front[i] &&
        point.error - best.error <= std::max(kMinDifference, spread) &&
        is_faster(point, *choice)) {
      choice = &point;
    }
  }
  std::string text = "Take " + choice->name + " (" +
                     DurationText(choice->seconds) +
                     "): no setting is measurably more accurate";
  const TradeoffPoint& fastest =
      *std::min_element(points.begin(), points.end(), is_faster);
  if (fastest.name != choice->name) {
    text += "; " + fastest.name + " needs " +
            FormatNumber("%.0f %%", 100 * fastest.seconds / choice->seconds) +
            " of its time and gets " +
            PercentPoints(fastest.error - choice->error) +
            " more of the pixels wrong";
  }
  return text + ".";
}

}  // namespace structnerf
