// The training objective's terms together. One by one they are in
// image_terms_test.cc and depth_terms_test.cc, their derivatives in
// training_gradients_test.cc; which rays are drawn is in ray_drawer_test.cc.

#include "nerf/train/training_objective.h"
#include "tests/nerf/train/objective_scene.h"
#include "tests/nerf/train/step_losses.h"

#include <vector>

#include <gtest/gtest.h>

namespace structnerf {
namespace {

TEST(TrainingLoss, TheTruthCostsNextToNothing) {
  const LossValues losses =
      EvaluateStep(ObjectiveScene(), 0, [](RayOutputs*) {});
  EXPECT_NEAR(Value(losses, LossTerm::kColor), 0, 1e-9);
  EXPECT_LT(Value(losses, LossTerm::kPatch), 0.02);
  EXPECT_GT(Value(losses, LossTerm::kPatch), 0);
  EXPECT_NEAR(Value(losses, LossTerm::kPlanar), 0, 1e-6);
  EXPECT_NEAR(Value(losses, LossTerm::kSparse), 0, 1e-9);
  // The wall is interpolated well.
  EXPECT_LT(Value(losses, LossTerm::kPrior), 1e-3);
}

// The same scene in millimetres and kilometres.
TEST(TrainingLoss, DoesNotDependOnTheScaleOfTheWorld) {
  const auto evaluate = [](const double scale) {
    ObjectiveScene test;
    test.plane.point *= scale;
    for (View& view : test.scene.views) {
      view.cam_from_world_translation *= scale;
    }
    for (SparsePoint& point : test.scene.points) {
      point.xyz *= scale;
    }
    test.frame = ComputeSceneFrame(test.scene);
    return EvaluateStep(
        test, 0, [](RayOutputs* outputs) { ScaleDepth(1.15f, outputs); });
  };
  const LossValues expected = evaluate(1);
  for (const double scale : {1e-3, 1e3}) {
    const LossValues losses = evaluate(scale);
    for (size_t term = 0; term < losses.size(); ++term) {
      EXPECT_NEAR(losses[term], expected[term], 1e-4 * expected[term] + 1e-7)
          << "term " << term;
    }
  }
}

TEST(TrainingLoss, SparseEndsAndPriorFades) {
  ObjectiveScene test;
  test.MakeFrontal();
  test.loss.sparse_fraction = 0.5;
  test.loss.prior_fraction = 0.4;
  std::vector<LossValues> losses;
  for (int step = 0; step < 100; ++step) {
    losses.push_back(EvaluateStep(
        test, step, [](RayOutputs* outputs) { ScaleDepth(1.2f, outputs); }));
  }
  for (int step = 0; step < 100; ++step) {
    if (step < 50) {
      EXPECT_GT(Value(losses[step], LossTerm::kSparse), 1e-3) << step;
    } else {
      EXPECT_EQ(Value(losses[step], LossTerm::kSparse), 0) << step;
    }
    if (step < 40) {
      EXPECT_NEAR(Value(losses[step], LossTerm::kPrior),
                  Value(losses[0], LossTerm::kPrior) * (1 - step / 40.0),
                  1e-4 * Value(losses[0], LossTerm::kPrior))
          << step;
      EXPECT_GT(Value(losses[step], LossTerm::kPrior), 0) << step;
    } else {
      EXPECT_EQ(Value(losses[step], LossTerm::kPrior), 0) << step;
    }
    EXPECT_GT(Value(losses[step], LossTerm::kPatch), 0) << step;
    EXPECT_GT(Value(losses[step], LossTerm::kPlanar), -1e-9) << step;
  }
}

TEST(TrainingLoss, FractionsOfZeroAndOne) {
  ObjectiveScene test;
  test.loss.sparse_fraction = 0;
  test.loss.prior_fraction = 0;
  const auto evaluate = [&](const int step) {
    return EvaluateStep(
        test, step, [](RayOutputs* outputs) { ScaleDepth(1.2f, outputs); });
  };
  EXPECT_EQ(Value(evaluate(0), LossTerm::kSparse), 0);
  EXPECT_EQ(Value(evaluate(0), LossTerm::kPrior), 0);
  test.loss.sparse_fraction = 1;
  test.loss.prior_fraction = 1;
  EXPECT_GT(Value(evaluate(99), LossTerm::kSparse), 0);
  EXPECT_GT(Value(evaluate(99), LossTerm::kPrior), 0);
}

}  // namespace
}  // namespace structnerf
