#pragma once

#include "colmap_plugin/tradeoff/pareto_front.h"

#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace structnerf {

// Time (logarithmic) against error: a dot with its name per point, a bar for
// the spread of its seeds, and a line through those on the Pareto front.
// `points` must not be empty and seconds must be positive.
cv::Mat3b PlotTradeoff(const std::vector<TradeoffPoint>& points,
                       const std::string& error_name);

}  // namespace structnerf
