#include "colmap_plugin/tradeoff/pareto_front.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TradeoffPoint MakePoint(const std::string& name,
                        const double seconds,
                        const double error,
                        const double half_spread = 0) {
  return {name, seconds, error, error - half_spread, error + half_spread};
}

TEST(ParetoFront, HasWhatNoOtherBeatsInBoth) {
  EXPECT_THAT(FindParetoFront({MakePoint("fast", 10, 0.5),
                               MakePoint("worse and slower", 20, 0.6),
                               MakePoint("good", 30, 0.3),
                               MakePoint("slower, the same", 40, 0.3),
                               MakePoint("best", 90, 0.2)}),
              ElementsAre(true, false, true, false, true));
}

TEST(ParetoFront, EqualPointsAreBothOnIt) {
  EXPECT_THAT(
      FindParetoFront({MakePoint("a", 10, 0.5), MakePoint("b", 10, 0.5)}),
      ElementsAre(true, true));
}

TEST(TradeoffAdvice, IsTheFastestThatIsNotMeasurablyWorse) {
  const std::string advice = TradeoffAdvice({MakePoint("low", 20, 0.42),
                                             MakePoint("medium", 40, 0.305),
                                             MakePoint("high", 90, 0.30)});
  EXPECT_THAT(advice, HasSubstr("Take medium (40 s)"));
  EXPECT_THAT(advice, HasSubstr("low needs 50 % of its time"));
  EXPECT_THAT(advice, HasSubstr("11.5 % more"));
}

TEST(TradeoffAdvice, AClearGainIsWorthItsTime) {
  EXPECT_THAT(TradeoffAdvice({MakePoint("low", 20, 0.42),
                              MakePoint("medium", 40, 0.33),
                              MakePoint("high", 90, 0.30)}),
              HasSubstr("Take high"));
}

TEST(TradeoffAdvice, TheSpreadOfSeedsHidesAGain) {
  EXPECT_THAT(TradeoffAdvice({MakePoint("medium", 40, 0.33, 0.02),
                              MakePoint("high", 90, 0.30)}),
              HasSubstr("Take medium"));
}

TEST(TradeoffAdvice, SpreadDoesNotPutASettingBeforeABetterOne) {
  EXPECT_THAT(TradeoffAdvice({MakePoint("best", 100, 0.30),
                              MakePoint("middle", 50, 0.34, 0.02),
                              MakePoint("fast", 10, 0.32)}),
              HasSubstr("Take best"));
}

TEST(TradeoffAdvice, OneSettingIsTaken) {
  EXPECT_EQ(TradeoffAdvice({MakePoint("low", 20, 0.42)}),
            "Take low (20 s): no setting is measurably more accurate.");
}

}  // namespace
}  // namespace structnerf
