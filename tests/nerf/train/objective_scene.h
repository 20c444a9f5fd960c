#pragma once

#include "nerf/train/training_objective.h"
#include "tests/nerf/plane_scene.h"

#include <memory>
#include <vector>

namespace structnerf {

// Four views of a textured wall with everything an objective may use: sparse
// points, planar segments, source views. All terms are on.
class ObjectiveScene {
 public:
  ObjectiveScene();

  // All views see each other.
  TrainingObjective MakeObjective() const;

  // The image point, of the training image, that a ray goes through and the
  // view it starts from.
  struct ImagePoint {
    int view_idx = -1;
    double x = 0;
    double y = 0;
    int Col() const { return static_cast<int>(x); }
    int Row() const { return static_cast<int>(y); }

    // Up to rounding; sparse points lie elsewhere.
    bool IsPixelCenter() const;
  };
  ImagePoint Identify(const RayTile& rays, int ray) const;

  // z-depth of the wall along a ray, field units.
  double TrueDepth(const ImagePoint& point) const;

  // What rendering the wall would give: its depth, its colour, no spread.
  RayOutputs TrueOutputs(const RayTile& rays) const;

  // Turns the wall and moves the cameras so that every pixel of every view has
  // the same depth; leaves a single sparse point.
  void MakeFrontal();

  // Adds a point on the wall, seen by all views.
  void AddPoint(double x, double y, double error);

  // Gives view 1 a depth prior: the wall's depth times a factor, almost
  // certain.
  void AddPrior(float factor);

  TexturedPlane plane;
  Scene scene;
  SceneFrame frame;
  LossOptions loss;
  TrainingOptions training;
  std::vector<int> train_view_idxs = {0, 1, 2, 3};
};

}  // namespace structnerf
