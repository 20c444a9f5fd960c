#include "nerf/view_selection.h"

#include "nerf/util/random.h"
#include "tests/nerf/plane_scene.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace structnerf {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;
using testing::UnorderedElementsAre;

Scene MakeScene(const std::vector<double>& camera_xs) {
  Scene scene;
  for (const double x : camera_xs) {
    scene.views.push_back(MakeView("image" + std::to_string(scene.views.size()),
                                   MakeCamera(40, 30, 30),
                                   {x, 0, 0}));
  }
  return scene;
}

void AddPoints(Scene* scene,
               const std::vector<int>& view_idxs,
               const int count,
               const double depth = 5) {
  for (int i = 0; i < count; ++i) {
    scene->points.push_back(
        MakePoint(*scene, {0.01 * i, 0.02 * i, depth}, view_idxs));
  }
}

TEST(SelectSourceViews, SharedPointsBeatTheOrderOfFiles) {
  // Neighbours in the list share nothing, views two apart do.
  Scene scene = MakeScene({0, 9, 0.5, 9.5});
  AddPoints(&scene, {0, 2}, 20);
  AddPoints(&scene, {1, 3}, 20);
  const auto sources = SelectSourceViews(scene, 1);
  EXPECT_THAT(sources[0], ElementsAre(2));
  EXPECT_THAT(sources[1], ElementsAre(3));
  EXPECT_THAT(sources[2], ElementsAre(0));
  EXPECT_THAT(sources[3], ElementsAre(1));
}

// A walk in shuffled order has the same sources as in order.
TEST(SelectSourceViews, OrderOfViewsPlaysNoRole) {
  constexpr int kNumViews = 12;
  std::vector<double> xs(kNumViews);
  for (int i = 0; i < kNumViews; ++i) {
    xs[i] = 0.4 * i + 0.013 * i * i;
  }
  std::vector<int> order(kNumViews);
  std::iota(order.begin(), order.end(), 0);
  Random random(4);
  for (int i = kNumViews - 1; i > 0; --i) {
    std::swap(order[i], order[random.NextBelow(i + 1)]);
  }
  const auto make = [&](const std::vector<int>& walk_of_view) {
    std::vector<double> shuffled;
    for (const int i : walk_of_view) {
      shuffled.push_back(xs[i]);
    }
    Scene scene = MakeScene(shuffled);
    // Each point is seen from half the walk.
    for (int p = 0; p < 200; ++p) {
      const double x = 0.03 * p;
      std::vector<int> seen_by;
      for (int v = 0; v < kNumViews; ++v) {
        if (std::abs(shuffled[v] - x) < 1.5) {
          seen_by.push_back(v);
        }
      }
      scene.points.push_back(MakePoint(scene, {x, 0.1, 4}, seen_by));
    }
    return scene;
  };
  std::vector<int> in_order(kNumViews);
  std::iota(in_order.begin(), in_order.end(), 0);
  const auto expected = SelectSourceViews(make(in_order), 4);
  const auto sources = SelectSourceViews(make(order), 4);
  for (int v = 0; v < kNumViews; ++v) {
    std::vector<int> walk;
    for (const int source : sources[v]) {
      walk.push_back(order[source]);
    }
    EXPECT_EQ(walk, expected[order[v]]);
  }
}

TEST(SelectSourceViews, MorePointsAreBetter) {
  Scene scene = MakeScene({0, 0.5, -0.5, 0.5});
  scene.views[3] = MakeView("other side", scene.views[0].camera, {0, 0.5, 0});
  AddPoints(&scene, {0, 1}, 5);
  AddPoints(&scene, {0, 2}, 30);
  AddPoints(&scene, {0, 3}, 10);
  EXPECT_THAT(SelectSourceViews(scene, 3)[0], ElementsAre(2, 3, 1));
}

TEST(SelectSourceViews, UsefulAnglesAreBetter) {
  // Angles at a point 5 in front: 0.3, 6, 17 and 58 degrees.
  Scene scene = MakeScene({0, 0.026, 0.525, 1.5, 8});
  AddPoints(&scene, {0, 1, 2, 3, 4}, 20);
  EXPECT_THAT(SelectSourceViews(scene, 4)[0], ElementsAre(2, 3, 1, 4));
}

TEST(SelectSourceViews, ViewsWithoutSharedPointsAreFilledUpByPose) {
  Scene scene = MakeScene({0, 3, 1, 2});
  scene.views.push_back(
      MakeView("looks away", scene.views[0].camera, {0.5, 0, 0}, {0, 0, -1}));
  AddPoints(&scene, {0, 1}, 3);
  const auto sources = SelectSourceViews(scene, 8);
  // The one that shares points first, then the nearest that look the same way.
  EXPECT_THAT(sources[0], ElementsAre(1, 2, 3));
  EXPECT_THAT(sources[2], ElementsAre(0, 3, 1));
  EXPECT_THAT(sources[4], IsEmpty());
}

TEST(SelectSourceViews, ViewsInOnePlaceAreNoSources) {
  for (const double offset : {0.0, 1e7}) {
    // Two pairs of cameras in the same place, as good as double tells them
    // apart, the second of each turned.
    Scene scene = MakeScene({offset, offset, offset + 1, offset + 1});
    for (const int v : {1, 3}) {
      scene.views[v] = MakeView("turned",
                                scene.views[v].camera,
                                scene.views[v - 1].ProjectionCenter(),
                                {0.1, 0.05, 1});
    }
    for (int i = 0; i < 20; ++i) {
      scene.points.push_back(
          MakePoint(scene, {offset + 0.1 * i, 0.02 * i, 5}, {0, 1, 2, 3}));
    }
    const auto sources = SelectSourceViews(scene, 8);
    EXPECT_THAT(sources[0], UnorderedElementsAre(2, 3));
    EXPECT_THAT(sources[1], UnorderedElementsAre(2, 3));
    EXPECT_THAT(sources[2], UnorderedElementsAre(0, 1));
    EXPECT_THAT(sources[3], UnorderedElementsAre(0, 1));
    // Nor without points.
    scene.points.clear();
    EXPECT_THAT(SelectSourceViews(scene, 8)[0], UnorderedElementsAre(2, 3));
  }
}

TEST(SelectSourceViews, OnlyAsManyAsAskedForAndNeverItself) {
  Scene scene = MakeScene({0, 0.3, 0.6, 0.9, 1.2});
  AddPoints(&scene, {0, 1, 2, 3, 4}, 10);
  // A point that was matched twice in one view.
  scene.points.push_back(MakePoint(scene, {0, 0, 5}, {2, 2, 2}));
  for (const int num_sources : {1, 2, 4, 9}) {
    const auto sources = SelectSourceViews(scene, num_sources);
    for (int v = 0; v < 5; ++v) {
      EXPECT_EQ(sources[v].size(),
                static_cast<size_t>(std::min(num_sources, 4)));
      EXPECT_THAT(sources[v], Not(Contains(v)));
    }
  }
}

TEST(SelectSourceViews, NoViews) {
  EXPECT_THAT(SelectSourceViews(Scene(), 4), IsEmpty());
}

// Not only left out: others take their places.
TEST(SelectSourceViews, OnlyCandidatesAreChosen) {
  Scene scene;
  for (int v = 0; v < 6; ++v) {
    scene.views.push_back(
        MakeView(std::to_string(v), MakeCamera(16, 12, 12), {0.2 * v, 0, 0}));
  }
  scene.points = {MakePoint(scene, {0, 0, 4}, {0, 1, 2, 3, 4, 5})};
  const auto all = SelectSourceViews(scene, 2);
  EXPECT_THAT(all[0], ElementsAre(2, 3));
  const auto sources = SelectSourceViews(scene, 2, {0, 1, 3, 4, 5});
  EXPECT_THAT(sources[0], ElementsAre(3, 4));
  for (const std::vector<int>& of_view : sources) {
    EXPECT_THAT(of_view, testing::SizeIs(2));
    EXPECT_THAT(of_view, testing::Not(testing::Contains(2)));
  }
}

TEST(SelectTrainingSources, CovisibleOnesAreThoseThatWereSelected) {
  const std::vector<std::vector<int>> sources = {{2, 1}, {0}, {1, 0}};
  EXPECT_EQ(SelectTrainingSources(sources, LossOptions(), {0, 1, 2}), sources);
}

TEST(SelectTrainingSources, NeighborsAreTwoOnEachSide) {
  LossOptions options;
  options.source_selection = "neighbors";
  options.num_sources = 4;
  // View 3 is held out.
  const auto sources = SelectTrainingSources(
      std::vector<std::vector<int>>(7, {6}), options, {0, 1, 2, 4, 5, 6});
  EXPECT_THAT(sources[0], ElementsAre(1, 2));
  EXPECT_THAT(sources[1], ElementsAre(0, 2, 4));
  EXPECT_THAT(sources[2], ElementsAre(1, 4, 0, 5));
  EXPECT_THAT(sources[3], ElementsAre(2, 4, 1, 5));
  EXPECT_THAT(sources[6], ElementsAre(5, 4));
}

TEST(IsHeldOutTest, TheLastOfEveryFew) {
  std::vector<size_t> held_out;
  for (size_t v = 0; v < 25; ++v) {
    if (IsHeldOut(v, 8)) {
      held_out.push_back(v);
    }
    EXPECT_FALSE(IsHeldOut(v, 0));
  }
  EXPECT_EQ(held_out, (std::vector<size_t>{7, 15, 23}));
}

TEST(IsHeldOutTest, EveryViewIsHeldOutOrTrainedOn) {
  EXPECT_THAT(HeldOutViewIdxs(7, 3), ElementsAre(2, 5));
  EXPECT_THAT(TrainedViewIdxs(7, 3), ElementsAre(0, 1, 3, 4, 6));
  EXPECT_TRUE(HeldOutViewIdxs(3, 0).empty());
  EXPECT_THAT(TrainedViewIdxs(3, 0), ElementsAre(0, 1, 2));
}

TEST(SelectAppearancesTest, HeldOutViewsTakeZerosOrTheirNeighbors) {
  const auto zeros = SelectAppearances(6, {0, 2, 3}, "zero");
  EXPECT_THAT(zeros[1], ElementsAre(1, 1));
  EXPECT_THAT(zeros[2], ElementsAre(-1, -1));
  const auto neighbors = SelectAppearances(6, {0, 2, 3, 5}, "neighbors");
  EXPECT_THAT(neighbors[0], ElementsAre(1, 1));
  EXPECT_THAT(neighbors[1], ElementsAre(1, 1));
  EXPECT_THAT(neighbors[2], ElementsAre(1, 4));
  EXPECT_THAT(neighbors[3], ElementsAre(1, 4));
  EXPECT_THAT(neighbors[5], ElementsAre(4, 4));
}

}  // namespace
}  // namespace structnerf
