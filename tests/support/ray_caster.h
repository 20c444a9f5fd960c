#pragma once

#include "tests/support/primitive.h"

#include <vector>

#include <Eigen/Core>

namespace structnerf::room {

struct Hit {
  SurfacePoint surface;
  int primitive_idx = -1;
};

// Casts rays at many primitives, through a tree of bounding boxes.
class RayCaster {
 public:
  explicit RayCaster(std::vector<Primitive> primitives);

  // The nearest hit; false if the ray leaves the scene.
  bool Cast(const Ray& ray, Hit* hit) const;

  // Whether anything lies strictly between two points. Surfaces within
  // `tolerance` metres of either end do not count.
  bool IsOccluded(const Eigen::Vector3d& from,
                  const Eigen::Vector3d& to,
                  double tolerance) const;

  const std::vector<Primitive>& Primitives() const { return primitives_; }

 private:
  struct Node {
    Eigen::Vector3d min_corner;
    Eigen::Vector3d max_corner;
    // Range in `order_` of a leaf, which has no children.
    int begin = 0;
    int end = 0;
    int left = -1;  // children: nodes_[left] and nodes_[right]
    int right = -1;
  };

  // Returns the node's index.
  int BuildNode(int begin, int end, int depth);
  bool CastBetween(
      const Ray& ray, double min_t, double max_t, bool any_hit, Hit* hit) const;

  std::vector<Primitive> primitives_;
  std::vector<int> order_;  // into primitives_
  std::vector<Node> nodes_;
};

}  // namespace structnerf::room
