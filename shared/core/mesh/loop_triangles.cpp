#include "shared/core/mesh/loop_triangles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isosplat {
namespace {

constexpr double kForbidden = std::numeric_limits<double>::infinity();

/// The length of the line between the middles of two cut edges.
double length_of_line(CellEdge a, CellEdge b) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto middle = [axis](int edge) {
      return axis == axis_of(edge) ? 0.5 : double(low_corner(edge) >> axis & 1);
    };
    const double d = middle(a) - middle(b);
    sum += d * d;
  }
  return std::sqrt(sum);
}

/// The same; kForbidden if the line lies in a face.
double line_cost(CellEdge a, CellEdge b) {
  return faces_of_edge(a) & faces_of_edge(b) ? kForbidden : length_of_line(a, b);
}

/// Costs and choices for the parts of a polygon between vertices i < j (G. T. Klincsek, "Minimal
/// triangulations of polygonal domains", 1980).
class PolygonParts {
 public:
  explicit PolygonParts(std::span<const CellEdge> loop) : loop_(loop) {
    const size_t n = loop.size();
    for (size_t span = 2; span < n; ++span) {
      for (size_t i = 0; i + span < n; ++i) choose(i, i + span);
    }
  }

  bool is_possible() const { return cost_[0][loop_.size() - 1] < kForbidden; }

  void append(size_t i, size_t j, std::vector<CellTriangle>& triangles) const {
    if (j < i + 2) return;
    const size_t k = apex_[i][j];
    triangles.push_back({loop_[i], loop_[k], loop_[j]});
    append(i, k, triangles);
    append(k, j, triangles);
  }

 private:
  /// The line between vertices i < j costs nothing if it is an edge of the polygon.
  double line(size_t i, size_t j) const {
    const bool is_side = j == i + 1 || (i == 0 && j == loop_.size() - 1);
    return is_side ? 0 : line_cost(loop_[i], loop_[j]);
  }

  void choose(size_t i, size_t j) {
    double best = kForbidden;
    for (size_t k = i + 1; k < j; ++k) {
      const double cost = cost_[i][k] + cost_[k][j] + line(i, k) + line(k, j);
      if (cost >= best) continue;
      best = cost;
      apex_[i][j] = k;
    }
    cost_[i][j] = best;
  }

  std::span<const CellEdge> loop_;
  std::array<std::array<double, kCellEdges>, kCellEdges> cost_{};
  std::array<std::array<size_t, kCellEdges>, kCellEdges> apex_{};
};

/// Strips of triangles between two loops. Lines i of the first and j of the second loop, modulo
/// their sizes. The direction of the second loop is reversed: both run the same way around.
class Strip {
 public:
  struct Line {
    size_t a, b;
  };

  /// The cheapest strip from the line (0, 0) once around.
  Strip(std::span<const CellEdge> a, std::span<const CellEdge> b) : a_(a), b_(b) {
    for (size_t i = 0; i <= a.size(); ++i) {
      for (size_t j = 0; j <= b.size(); ++j) choose(i, j);
    }
  }

  double cost() const { return cost_[a_.size()][b_.size()]; }

  /// The lines from (0, 0) to (a.size(), b.size()).
  std::vector<Line> lines() const {
    std::vector<Line> lines{{a_.size(), b_.size()}};
    for (size_t i = a_.size(), j = b_.size(); i + j > 0;) {
      --(from_a_[i][j] ? i : j);
      lines.push_back({i, j});
    }
    std::reverse(lines.begin(), lines.end());
    return lines;
  }

  /// Whether all lines differ, except for the first and the last: others would be edges of four
  /// triangles.
  bool is_simple() const {
    std::array<std::array<bool, kCellEdges>, kCellEdges> seen{};
    const auto path = lines();
    for (const Line& line : std::span(path).subspan(1)) {
      bool& found = seen[line.a % a_.size()][line.b % b_.size()];
      if (found) return false;
      found = true;
    }
    return true;
  }

 private:
  void choose(size_t i, size_t j) {
    if (i + j == 0) return;
    const double from_a = i > 0 ? cost_[i - 1][j] : kForbidden;
    const double from_b = j > 0 ? cost_[i][j - 1] : kForbidden;
    from_a_[i][j] = from_a <= from_b;
    cost_[i][j] = std::min(from_a, from_b) + line_cost(a_[i % a_.size()], b_[j % b_.size()]);
  }

  std::span<const CellEdge> a_, b_;
  std::array<std::array<double, kCellEdges + 1>, kCellEdges + 1> cost_{};
  std::array<std::array<bool, kCellEdges + 1>, kCellEdges + 1> from_a_{};
};

struct BestStrip {
  std::vector<CellEdge> b;         ///< reversed, and rotated to the first line
  std::vector<Strip::Line> lines;  ///< none if there is no such strip
};

/// The cheapest simple strip without lines in faces.
BestStrip find_inner_strip(std::span<const CellEdge> a, std::span<const CellEdge> loop) {
  BestStrip best;
  std::vector<CellEdge> other(loop.rbegin(), loop.rend());
  double least = kForbidden;
  for (size_t turn = 0; turn < other.size(); ++turn) {
    const Strip strip(a, other);
    if (strip.cost() < least && strip.is_simple()) {
      least = strip.cost();
      best = {other, strip.lines()};
    }
    std::rotate(other.begin(), other.begin() + 1, other.end());
  }
  return best;
}

/// Advances evenly along both loops. Of all rotations of the second loop, it chooses the one with
/// the shortest lines.
BestStrip find_even_strip(std::span<const CellEdge> a, std::span<const CellEdge> loop) {
  BestStrip best;
  std::vector<Strip::Line> lines{{0, 0}};
  for (size_t i = 0, j = 0; i < a.size() || j < loop.size();) {
    const bool advances_a = (2 * i + 1) * loop.size() <= (2 * j + 1) * a.size();
    ++(advances_a ? i : j);
    lines.push_back({i, j});
  }
  std::vector<CellEdge> other(loop.rbegin(), loop.rend());
  double least = kForbidden;
  for (size_t turn = 0; turn < other.size(); ++turn) {
    double cost = 0;
    for (const auto& line : lines) {
      cost += length_of_line(a[line.a % a.size()], other[line.b % other.size()]);
    }
    if (cost < least) {
      least = cost;
      best = {other, lines};
    }
    std::rotate(other.begin(), other.begin() + 1, other.end());
  }
  return best;
}

/// The triangles of a strip between any vertices.
void append_strip(std::span<const uint8_t> a, std::span<const uint8_t> b,
                  std::span<const Strip::Line> lines, std::vector<CellTriangle>& triangles) {
  for (size_t k = 1; k < lines.size(); ++k) {
    const auto [i, j] = lines[k - 1];
    const bool advances_a = lines[k].a != i;
    triangles.push_back({a[i % a.size()],
                         advances_a ? a[(i + 1) % a.size()] : b[(j + 1) % b.size()],
                         b[j % b.size()]});
  }
}

}  // namespace

CellTriangles fill_loop(std::span<const CellEdge> loop) {
  CellTriangles result;
  const PolygonParts parts(loop);
  if (parts.is_possible()) {
    parts.append(0, loop.size() - 1, result.triangles);
    return result;
  }
  for (size_t i = 0; i < loop.size(); ++i) {
    result.triangles.push_back({loop[i], loop[(i + 1) % loop.size()], uint8_t{kCellEdges}});
  }
  result.means.emplace_back(loop.begin(), loop.end());
  return result;
}

CellTriangles connect_loops(std::span<const CellEdge> a, std::span<const CellEdge> b) {
  CellTriangles result;
  const BestStrip direct = find_inner_strip(a, b);
  if (!direct.lines.empty()) {
    append_strip(a, direct.b, direct.lines, result.triangles);
    return result;
  }
  // A ring that has a vertex for each of a, in the middle between it and its neighbours in b.
  const BestStrip even = find_even_strip(a, b);
  std::vector<uint8_t> ring;
  std::vector<Strip::Line> to_ring{{0, 0}};
  for (size_t i = 0; i < a.size(); ++i) {
    ring.push_back(static_cast<uint8_t>(kCellEdges + i));
    auto& mean = result.means.emplace_back();
    for (const auto& line : std::span(even.lines).subspan(1)) {
      if (line.a % a.size() != i) continue;
      mean.push_back(a[i]);
      mean.push_back(even.b[line.b % b.size()]);
    }
    to_ring.push_back({i + 1, i});
    to_ring.push_back({i + 1, i + 1});
  }
  append_strip(a, ring, to_ring, result.triangles);
  append_strip(ring, even.b, even.lines, result.triangles);
  return result;
}

}  // namespace isosplat
