#include "tests/support/ray_caster.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace structnerf::room {
namespace {

constexpr int kMaxLeafSize = 2;
// Beyond this depth ranges are halved, so the whole tree is not much deeper.
constexpr int kMaxSplitDepth = 32;
constexpr int kMaxDepth = 64;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where a ray enters a box, at the earliest 0; infinity if it misses it.
double EnterBox(const Eigen::Vector3d& min_corner,
                const Eigen::Vector3d& max_corner,
                const Eigen::Vector3d& origin,
                const Eigen::Vector3d& inverse_direction) {
  double enter = 0;
  double leave = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    const double a =
        (min_corner[axis] - origin[axis]) * inverse_direction[axis];
    const double b =
        (max_corner[axis] - origin[axis]) * inverse_direction[axis];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : kInfinity;
}

struct Bounds {
  Eigen::Vector3d min_corner = Eigen::Vector3d::Constant(kInfinity);
  Eigen::Vector3d max_corner = Eigen::Vector3d::Constant(-kInfinity);

  void Add(const Primitive& primitive) {
    Eigen::Vector3d low;
    Eigen::Vector3d high;
    BoundingBox(primitive, &low, &high);
    min_corner = min_corner.cwiseMin(low);
    max_corner = max_corner.cwiseMax(high);
  }

  double HalfArea() const {
    const Eigen::Vector3d size = max_corner - min_corner;
    return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
  }
};

void SortAlong(const int axis,
               const std::vector<Primitive>& primitives,
               const std::vector<int>::iterator begin,
               const std::vector<int>::iterator end) {
  std::sort(begin, end, [&](const int a, const int b) {
    const double center_a = primitives[a].center[axis];
    const double center_b = primitives[b].center[axis];
    return std::tie(center_a, a) < std::tie(center_b, b);
  });
}

// Sorts a range of primitives and returns how many of them the first child
// gets, so that the expected number of intersection tests is least: a box is
// hit in proportion to its surface.
int SplitBySurface(const std::vector<Primitive>& primitives,
                   const std::vector<int>::iterator begin,
                   const std::vector<int>::iterator end) {
  const int count = static_cast<int>(end - begin);
  double best_cost = kInfinity;
  int best_axis = 0;
  int best_count = count / 2;
  for (int axis = 0; axis < 3; ++axis) {
    SortAlong(axis, primitives, begin, end);
    std::vector<double> costs(count, 0);
    Bounds left;
    Bounds right;
    for (int i = 1; i < count; ++i) {
      left.Add(primitives[begin[i - 1]]);
      costs[i] += i * left.HalfArea();
      right.Add(primitives[begin[count - i]]);
      costs[count - i] += i * right.HalfArea();
    }
    const auto best = std::min_element(costs.begin() + 1, costs.end());
    if (*best < best_cost) {
      best_cost = *best;
      best_axis = axis;
      best_count = static_cast<int>(best - costs.begin());
    }
  }
  SortAlong(best_axis, primitives, begin, end);
  return best_count;
}

}  // namespace

RayCaster::RayCaster(std::vector<Primitive> primitives)
    : primitives_(std::move(primitives)), order_(primitives_.size()) {
  if (primitives_.empty()) {
    throw std::invalid_argument("A ray caster needs at least one primitive.");
  }
  std::iota(order_.begin(), order_.end(), 0);
  BuildNode(0, static_cast<int>(order_.size()), 0);
}

int RayCaster::BuildNode(const int begin, const int end, const int depth) {
  Bounds bounds;
  for (int i = begin; i < end; ++i) {
    bounds.Add(primitives_[order_[i]]);
  }
  const int node_idx = static_cast<int>(nodes_.size());
  nodes_.push_back({bounds.min_corner, bounds.max_corner, begin, end, -1, -1});
  if (end - begin > kMaxLeafSize) {
    const int middle = depth < kMaxSplitDepth
                           ? begin + SplitBySurface(primitives_,
                                                    order_.begin() + begin,
                                                    order_.begin() + end)
                           : (begin + end) / 2;
    const int left = BuildNode(begin, middle, depth + 1);
    const int right = BuildNode(middle, end, depth + 1);
    nodes_[node_idx].left = left;
    nodes_[node_idx].right = right;
  }
  return node_idx;
}

bool RayCaster::Cast(const Ray& ray, Hit* hit) const {
  return CastBetween(
      ray, 1e-9, std::numeric_limits<double>::infinity(), false, hit);
}

bool RayCaster::IsOccluded(const Eigen::Vector3d& from,
                           const Eigen::Vector3d& to,
                           const double tolerance) const {
  const Ray ray{from, to - from};
  const double relative = tolerance / ray.direction.norm();
  Hit ignored;
  return CastBetween(ray, relative, 1 - relative, true, &ignored);
}

bool RayCaster::CastBetween(const Ray& ray,
                            const double min_t,
                            const double max_t,
                            const bool any_hit,
                            Hit* hit) const {
  struct Visit {
    int node_idx;
    double enter;
  };
  const Eigen::Vector3d inverse = ray.direction.cwiseInverse();
  const auto visit = [&](const int node_idx) -> Visit {
    const Node& node = nodes_[node_idx];
    return {node_idx,
            EnterBox(node.min_corner, node.max_corner, ray.origin, inverse)};
  };
  double nearest = max_t;
  hit->primitive_idx = -1;
  SurfacePoint candidate;
  // Every level adds one node at most.
  Visit stack[kMaxDepth + 1];
  int stack_size = 0;
  stack[stack_size++] = visit(0);
  while (stack_size > 0) {
    const Visit next = stack[--stack_size];
    if (!(next.enter < nearest)) {
      continue;
    }
    const Node& node = nodes_[next.node_idx];
    if (node.left >= 0) {
      Visit near = visit(node.left);
      Visit far = visit(node.right);
      if (far.enter < near.enter) {
        std::swap(near, far);
      }
      stack[stack_size++] = far;
      stack[stack_size++] = near;
      continue;
    }
    for (int i = node.begin; i < node.end; ++i) {
      const int primitive_idx = order_[i];
      if (Intersect(
              primitives_[primitive_idx], ray, min_t, nearest, &candidate)) {
        nearest = candidate.t;
        hit->surface = candidate;
        hit->primitive_idx = primitive_idx;
        if (any_hit) {
          return true;
        }
      }
    }
  }
  return hit->primitive_idx >= 0;
}

}  // namespace structnerf::room
