#include "nerf/planes/plane_votes.h"

#include "nerf/view_selection.h"

#include <algorithm>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

// Photographs in a row, each with those before and behind it as sources.
std::vector<std::vector<int>> SourcesInARow(const int num_views) {
  std::vector<std::vector<int>> sources(num_views);
  for (int v = 0; v < num_views; ++v) {
    if (v > 0) {
      sources[v].push_back(v - 1);
    }
    if (v + 1 < num_views) {
      sources[v].push_back(v + 1);
    }
  }
  return sources;
}

TEST(SelectVoters, AreAllOthersOfASmallScene) {
  EXPECT_THAT(SelectVoters(1, {0, 1, 2, 3}, SourcesInARow(4)),
              ElementsAre(0, 2, 3));
  // Whether or not they are anybody's source.
  EXPECT_THAT(SelectVoters(2, {0, 1, 2}, {{}, {}, {}}), ElementsAre(0, 1));
  // Of those that have a say.
  EXPECT_THAT(SelectVoters(1, {0, 1, 3}, {{}, {}, {}, {}}), ElementsAre(0, 3));
  EXPECT_THAT(SelectVoters(2, {0, 1, 3}, {{}, {}, {}, {}}),
              ElementsAre(0, 1, 3));
  constexpr int kNumFew = static_cast<int>(kMaxVoters) + 1;
  EXPECT_THAT(SelectVoters(0,
                           TrainedViewIdxs(kNumFew, /*test_every=*/0),
                           SourcesInARow(kNumFew)),
              SizeIs(kMaxVoters));
}

TEST(SelectVoters, AreTheNearestOfALargeScene) {
  constexpr int kMiddle = 500;
  const std::vector<int> voters = SelectVoters(
      kMiddle, TrainedViewIdxs(1000, /*test_every=*/0), SourcesInARow(1000));
  EXPECT_THAT(voters, SizeIs(kMaxVoters));
  EXPECT_EQ(std::count(voters.begin(), voters.end(), kMiddle), 0);
  const int reach = static_cast<int>(kMaxVoters) / 2;
  EXPECT_EQ(*std::min_element(voters.begin(), voters.end()), kMiddle - reach);
  EXPECT_EQ(*std::max_element(voters.begin(), voters.end()), kMiddle + reach);
}

TEST(SelectVoters, AreFewerWhereNoSourceLeadsFarther) {
  std::vector<std::vector<int>> sources(1000);
  sources[3] = {7, 9};
  sources[9] = {3, 11};
  EXPECT_THAT(SelectVoters(3, TrainedViewIdxs(1000, /*test_every=*/0), sources),
              ElementsAre(7, 9, 11));
  EXPECT_THAT(SelectVoters(0, TrainedViewIdxs(1000, /*test_every=*/0), sources),
              SizeIs(0));
}

TEST(PlaneLattice, CoversTheView) {
  for (const int width : {1, 159, 320, 641}) {
    const int height = 3 * width / 4 + 1;
    const PlaneLattice lattice(width, height);
    EXPECT_EQ(lattice.IndexOfPixel(width - 1, height - 1),
              lattice.NumCells() - 1);
    EXPECT_LT(lattice.CenterCol(lattice.NumCols() - 1), width);
    EXPECT_LT(lattice.CenterRow(lattice.NumRows() - 1), height);
  }
}

}  // namespace
}  // namespace structnerf
