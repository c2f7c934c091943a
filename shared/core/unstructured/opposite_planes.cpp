#include "shared/core/unstructured/opposite_planes.h"

#include <algorithm>
#include <limits>
#include <span>

namespace isosplat {
namespace {

constexpr size_t kFewPlanes = 16;
constexpr double kRounding = 1e-9;

bool is_opposite(const FacePlane& a, const FacePlane& b) {
  return dot(a.normal, b.normal) < kOpposite && a.distance + b.distance >= 0;
}

/// A tree over the normals: each node halves its planes along the axis of their largest extent.
class NormalTree {
 public:
  explicit NormalTree(std::vector<FacePlane>& planes) : planes_(planes) { add(0, planes.size()); }

  bool has_opposite(const FacePlane& plane) const { return has_opposite(0, plane); }

 private:
  struct Node {
    Vec3d low, high;  ///< of the normals
    double farthest;  ///< the largest distance
    size_t begin, end;
    size_t second = 0;  ///< the node of the second half, or 0; the first half follows at once
  };

  void add(size_t begin, size_t end) {
    constexpr double kMost = std::numeric_limits<double>::max();
    Node node{{kMost, kMost, kMost}, {-kMost, -kMost, -kMost}, -kMost, begin, end};
    for (size_t i = begin; i < end; ++i) {
      const Vec3d n = planes_[i].normal;
      node.low = {std::min(node.low.x, n.x), std::min(node.low.y, n.y), std::min(node.low.z, n.z)};
      node.high = {std::max(node.high.x, n.x), std::max(node.high.y, n.y),
                   std::max(node.high.z, n.z)};
      node.farthest = std::max(node.farthest, planes_[i].distance);
    }
    const size_t own = nodes_.size();
    nodes_.push_back(node);
    const Vec3d size = node.high - node.low;
    const double most = std::max({size.x, size.y, size.z});
    if (end - begin <= kFewPlanes || most < kRounding) return;
    const auto along = [&](const FacePlane& plane) {
      return size.x == most ? plane.normal.x : size.y == most ? plane.normal.y : plane.normal.z;
    };
    const size_t middle = begin + (end - begin) / 2;
    const auto at = [&](size_t i) { return planes_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end),
                     [&](const FacePlane& a, const FacePlane& b) { return along(a) < along(b); });
    add(begin, middle);
    nodes_[own].second = nodes_.size();
    add(middle, end);
  }

  bool has_opposite(size_t index, const FacePlane& plane) const {
    const Node& node = nodes_[index];
    if (node.farthest + plane.distance < 0) return false;
    double least = 0, most = 0;  // of the cosines
    const auto add_axis = [&](double n, double low, double high) {
      least += std::min(n * low, n * high);
      most += std::max(n * low, n * high);
    };
    add_axis(plane.normal.x, node.low.x, node.high.x);
    add_axis(plane.normal.y, node.low.y, node.high.y);
    add_axis(plane.normal.z, node.low.z, node.high.z);
    if (least > kOpposite + kRounding) return false;
    if (most < kOpposite - kRounding) return true;
    if (node.second > 0) {
      return has_opposite(index + 1, plane) || has_opposite(node.second, plane);
    }
    const auto own = std::span(planes_).subspan(node.begin, node.end - node.begin);
    return std::any_of(own.begin(), own.end(),
                       [&](const FacePlane& other) { return is_opposite(plane, other); });
  }

  std::vector<FacePlane>& planes_;
  std::vector<Node> nodes_;
};

}  // namespace

bool are_some_opposite(std::vector<FacePlane>& planes) {
  if (planes.size() <= 2 * kFewPlanes) {
    for (size_t i = 1; i < planes.size(); ++i) {
      for (size_t k = 0; k < i; ++k) {
        if (is_opposite(planes[i], planes[k])) return true;
      }
    }
    return false;
  }
  const NormalTree tree(planes);
  return std::any_of(planes.begin(), planes.end(),
                     [&](const FacePlane& plane) { return tree.has_opposite(plane); });
}

}  // namespace isosplat
