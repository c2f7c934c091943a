#include "shared/core/mesh/polygon_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

namespace isosplat {
namespace {

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

/// Twice the signed area of a triangle: above 0 if it is counter-clockwise.
double turn(PlanePoint a, PlanePoint b, PlanePoint c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/// Finds the sides that a horizontal line meets: the sides of each row of a subdivision.
class SideRows {
 public:
  /// sides: pairs of lowest and highest y.
  explicit SideRows(std::span<const std::array<double, 2>> sides) {
    if (sides.empty()) return;
    double high = -std::numeric_limits<double>::infinity(), sum = 0;
    low_ = std::numeric_limits<double>::infinity();
    for (const auto& [from, to] : sides) {
      low_ = std::min(low_, from);
      high = std::max(high, to);
      sum += to - from;
    }
    // So many rows that a side is in four of them on average, at most.
    const auto count = static_cast<double>(sides.size());
    const double rows = sum > 0 ? std::min(count, 3 * count * ((high - low_) / sum)) : 1;
    rows_ = std::max<size_t>(1, static_cast<size_t>(rows));
    per_unit_ = high > low_ ? static_cast<double>(rows_) / (high - low_) : 0;
    begin_.resize(rows_ + 1);
    for (const auto& [from, to] : sides) {
      for (size_t row = row_of(from); row <= row_of(to); ++row) ++begin_[row];
    }
    std::exclusive_scan(begin_.begin(), begin_.end(), begin_.begin(), size_t{0});
    sides_.resize(begin_.back());
    std::vector<size_t> end = begin_;
    for (size_t i = 0; i < sides.size(); ++i) {
      for (size_t row = row_of(sides[i][0]); row <= row_of(sides[i][1]); ++row) {
        sides_[end[row]++] = static_cast<uint32_t>(i);
      }
    }
  }

  /// Indices of sides, among them all that y is within.
  std::span<const uint32_t> at(double y) const {
    if (sides_.empty()) return {};
    const size_t row = row_of(y);
    return std::span(sides_).subspan(begin_[row], begin_[row + 1] - begin_[row]);
  }

 private:
  size_t row_of(double y) const {
    const double row = (y - low_) * per_unit_;
    return row > 0 ? std::min(static_cast<size_t>(row), rows_ - 1) : 0;
  }

  double low_ = 0, per_unit_ = 0;
  size_t rows_ = 1;
  std::vector<size_t> begin_;
  std::vector<uint32_t> sides_;
};

/// The sweep moves upwards, along y. A side is named by its first vertex. Sides that lead downwards
/// have the polygon on their right, where x is greater.
class PolygonSweep {
 public:
  PolygonSweep(std::span<const PlanePoint> points, std::span<const uint32_t> next)
      : points_(points), next_(next), before_(next.size()), rank_(next.size()) {
    for (uint32_t v = 0; v < next.size(); ++v) before_[next[v]] = v;
  }

  std::vector<std::array<uint32_t, 3>> run() {
    std::vector<uint32_t> order(points_.size());
    std::iota(order.begin(), order.end(), uint32_t{0});
    std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
      return std::tuple(points_[a].y, points_[a].x, a) < std::tuple(points_[b].y, points_[b].x, b);
    });
    for (uint32_t i = 0; i < order.size(); ++i) rank_[order[i]] = i;
    find_left_sides();
    part_of_.assign(points_.size(), kNone);
    triangles_.reserve(points_.size());
    for (const uint32_t v : order) pass(v);
    return std::move(triangles_);
  }

 private:
  /// A vertex of a chain.
  struct Link {
    uint32_t vertex, before, after;
  };
  /// A part of the sweep line inside of the polygon, between two sides. The chain below it, from
  /// the left side to the right one, bounds the triangles so far.
  struct Part {
    uint32_t left, right;  ///< sides
    uint32_t front, back;  ///< the ends of the chain: links
    uint32_t last;         ///< the link of the highest vertex
  };

  bool is_below(uint32_t a, uint32_t b) const { return rank_[a] < rank_[b]; }

  void find_left_sides() {
    std::vector<std::array<double, 2>> heights;
    for (uint32_t v = 0; v < next_.size(); ++v) {
      if (!is_below(next_[v], v)) continue;
      left_sides_.push_back(v);
      heights.push_back({points_[next_[v]].y, points_[v].y});
    }
    rows_ = SideRows(heights);
  }

  /// The part that contains a vertex; kNone if there is none.
  uint32_t part_around(uint32_t v) const {
    const PlanePoint at = points_[v];
    uint32_t nearest = kNone;
    double nearest_x = -std::numeric_limits<double>::infinity();
    for (const uint32_t index : rows_.at(at.y)) {
      const uint32_t side = left_sides_[index];
      const uint32_t low = next_[side];
      if (!is_below(low, v) || !is_below(v, side) || part_of_[side] == kNone) continue;
      const PlanePoint a = points_[low], b = points_[side];
      if (turn(a, b, at) > 0) continue;
      const double x = b.y > a.y ? a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x) : at.x;
      if (x < nearest_x) continue;
      nearest_x = x;
      nearest = side;
    }
    return nearest == kNone ? kNone : part_of_[nearest];
  }

  uint32_t add_link(uint32_t vertex, uint32_t before, uint32_t after) {
    links_.push_back({vertex, before, after});
    return static_cast<uint32_t>(links_.size() - 1);
  }

  /// Adds the triangle of two neighbours in a chain and v, if v is above them.
  bool fill(uint32_t a, uint32_t b, uint32_t v, bool always) {
    const uint32_t first = links_[a].vertex, second = links_[b].vertex;
    if (!always && !(turn(points_[first], points_[second], points_[v]) > 0)) return false;
    triangles_.push_back({first, second, v});
    return true;
  }

  /// Fills what v sees from the right end of a chain, and appends it. `end`: the last link.
  uint32_t append_right(uint32_t front, uint32_t end, uint32_t v) {
    while (end != front && fill(links_[end].before, end, v, false)) end = links_[end].before;
    const uint32_t link = add_link(v, end, kNone);
    links_[end].after = link;
    return link;
  }
  uint32_t append_left(uint32_t back, uint32_t end, uint32_t v) {
    while (end != back && fill(end, links_[end].after, v, false)) end = links_[end].after;
    const uint32_t link = add_link(v, kNone, end);
    links_[end].before = link;
    return link;
  }

  void set_sides(uint32_t part, uint32_t left, uint32_t right) {
    parts_[part].left = left;
    parts_[part].right = right;
    part_of_[left] = part_of_[right] = part;
  }

  void pass(uint32_t v) {
    const uint32_t from = before_[v], to = next_[v];
    if (from == v) return;  // a loop without sides
    const bool comes_up = is_below(from, v), goes_up = is_below(v, to);
    if (comes_up && goes_up) {
      Part& part = parts_[part_of_[from]];
      part.back = part.last = append_right(part.front, part.back, v);
      set_sides(part_of_[from], part.left, v);
    } else if (!comes_up && !goes_up) {
      Part& part = parts_[part_of_[v]];
      part.front = part.last = append_left(part.back, part.front, v);
      set_sides(part_of_[v], from, part.right);
    } else if (goes_up) {
      begin(v);
    } else {
      end(v);
    }
  }

  /// Both sides of v are above it: a part begins, or v divides a part.
  void begin(uint32_t v) {
    const uint32_t left = before_[v], right = v;
    const bool divides = turn(points_[left], points_[v], points_[next_[v]]) < 0;
    const uint32_t around = divides ? part_around(v) : kNone;
    const auto added = static_cast<uint32_t>(parts_.size());
    if (around == kNone) {
      const uint32_t link = add_link(v, kNone, kNone);
      parts_.push_back({left, right, link, link, link});
      set_sides(added, left, right);
      return;
    }
    // v sees the highest vertex of the chain.
    const Part old = parts_[around];
    const Link highest = links_[old.last];
    const uint32_t copy = add_link(highest.vertex, kNone, highest.after);
    if (highest.after != kNone) links_[highest.after].before = copy;
    links_[old.last].after = kNone;
    const uint32_t old_back = old.back == old.last ? copy : old.back;
    const uint32_t to_left = append_right(old.front, old.last, v);
    parts_[around] = {old.left, right, old.front, to_left, to_left};
    set_sides(around, old.left, right);
    const uint32_t to_right = append_left(old_back, copy, v);
    parts_.push_back({left, old.right, to_right, old_back, to_right});
    set_sides(added, left, old.right);
  }

  /// Both sides of v are below it: a part ends, or v joins two parts.
  void end(uint32_t v) {
    const uint32_t on_left = part_of_[before_[v]];  // v ends its right side
    const uint32_t on_right = part_of_[v];          // v ends its left side
    Part& part = parts_[on_left];
    if (on_left == on_right) {
      for (uint32_t link = part.front; link != part.back; link = links_[link].after) {
        fill(link, links_[link].after, v, true);
      }
      return;
    }
    const Part& other = parts_[on_right];
    const uint32_t link = append_right(part.front, part.back, v);
    const uint32_t rest = append_left(other.back, other.front, v);
    const uint32_t after = links_[rest].after;
    links_[link].after = after;
    links_[after].before = link;
    part.back = other.back;
    part.last = link;
    set_sides(on_left, part.left, other.right);
  }

  std::span<const PlanePoint> points_;
  std::span<const uint32_t> next_;
  std::vector<uint32_t> before_;
  std::vector<uint32_t> rank_;  ///< of a vertex in the order of the sweep
  std::vector<uint32_t> left_sides_;
  SideRows rows_{std::span<const std::array<double, 2>>{}};
  std::vector<uint32_t> part_of_;  ///< of a side
  std::vector<Part> parts_;
  std::vector<Link> links_;
  std::vector<std::array<uint32_t, 3>> triangles_;
};

}  // namespace

std::vector<std::array<uint32_t, 3>> polygon_triangles(std::span<const PlanePoint> points,
                                                       std::span<const uint32_t> next) {
  return PolygonSweep(points, next).run();
}

}  // namespace isosplat
