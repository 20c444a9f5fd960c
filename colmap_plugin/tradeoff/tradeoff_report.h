#pragma once

#include "colmap_plugin/tradeoff/pareto_front.h"
#include "colmap_plugin/tradeoff/tradeoff_run.h"

#include <string>
#include <vector>

namespace structnerf {

// A setting with the measurements of its seeds, at least one.
struct MeasuredSetting {
  TradeoffSetting setting;
  std::vector<TradeoffMeasurement> measurements;

  TradeoffPoint Point() const;
};

// Writes tradeoff.json, tradeoff.png and tradeoff.html, which needs no other
// file, into the scene's output folder. Returns the advice. Throws
// std::runtime_error, naming the file, if one cannot be written. `settings`
// must not be empty.
std::string WriteTradeoffReport(const TradeoffScene& scene,
                                const std::vector<MeasuredSetting>& settings);

}  // namespace structnerf
