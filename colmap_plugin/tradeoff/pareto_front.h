#pragma once

#include <string>
#include <vector>

namespace structnerf {

// What a setting costs and gives, over its seeds.
struct TradeoffPoint {
  std::string name;
  double seconds = 0;  // mean
  double error = 0;    // share of the pixels that are wrong, mean
  double min_error = 0;
  double max_error = 0;
};

// For each point, whether no other one is at least as fast and as accurate and
// better in one of the two.
std::vector<bool> FindParetoFront(const std::vector<TradeoffPoint>& points);

// One sentence: the fastest setting on the front whose error is not measurably
// larger than the least one, and what the fastest of all would save. A
// difference counts as measurable beyond one percent of the pixels or the
// spread of the seeds. `points` must not be empty.
std::string TradeoffAdvice(const std::vector<TradeoffPoint>& points);

}  // namespace structnerf
