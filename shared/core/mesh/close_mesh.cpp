#include "shared/core/mesh/close_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>

#include "shared/core/base/vec3.h"
#include "shared/core/mesh/mesh_cap.h"

namespace isosplat {
namespace {

double along(Vec3d v, int axis) {
  return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

Vec3d unit(int axis) {
  return {axis == 0 ? 1.0 : 0, axis == 1 ? 1.0 : 0, axis == 2 ? 1.0 : 0};
}

/// A face of the box: 2 · axis + side. u × v points outwards.
struct FaceAxes {
  int axis, side, u, v;

  explicit FaceAxes(int face) : axis(face >> 1), side(face & 1) {
    u = (axis + (side == 1 ? 1 : 2)) % 3;
    v = (axis + (side == 1 ? 2 : 1)) % 3;
  }
};

/// A point of a face's outline: a vertex where sides of the face end, or a corner of the box.
struct OutlinePoint {
  double distance = 0;  ///< along the outline, counter-clockwise seen from outside
  uint32_t vertex = 0;
  int corner = -1;      ///< bits: high along x, y, z
  bool begins = false;  ///< the outline after it is above the isovalue; of a corner: unknown
};

class BoxClosing {
 public:
  BoxClosing(MeshPart& mesh, Vec3d low, Vec3d high) : mesh_(mesh), low_(low), high_(high) {}

  Result<void> run() {
    find_sides();
    for (int face = 0; face < 6; ++face) {
      if (auto found = find_ends(face); !found) return found;
    }
    if (auto known = find_corners(); !known) return known;
    for (int face = 0; face < 6; ++face) {
      append_outline(face);
      const FaceAxes axes(face);
      auto closed = append_cap(mesh_, std::move(sides_[size_t(face)]), unit(axes.u), unit(axes.v));
      if (!closed) return closed;
    }
    return {};
  }

 private:
  double bound(int axis, int side) const { return along(side == 0 ? low_ : high_, axis); }

  /// Bit f: the vertex lies on face f.
  uint32_t faces_at(Vec3d at) const {
    uint32_t faces = 0;
    for (int face = 0; face < 6; ++face) {
      faces |= uint32_t{along(at, face >> 1) == bound(face >> 1, face & 1)} << face;
    }
    return faces;
  }

  /// Collects the edges on faces that only one triangle has, reversed. Triangles have no edges in
  /// faces of cells besides those in which the surface meets them, so others are edges of holes.
  void find_sides() {
    struct Edge {
      uint32_t low, high;
      uint8_t face;
      bool ascends;
    };
    std::vector<uint8_t> faces;
    faces.reserve(mesh_.vertices.positions.size());
    for (const Vec3d at : mesh_.vertices.positions) {
      faces.push_back(static_cast<uint8_t>(faces_at(at)));
    }
    std::vector<Edge> edges;
    for (const auto& triangle : mesh_.triangles) {
      for (size_t i = 0; i < 3; ++i) {
        const uint32_t a = triangle[i], b = triangle[(i + 1) % 3];
        const uint32_t common = faces[a] & faces[b];
        if (common == 0) continue;
        uint8_t face = 0;
        while (!(common >> face & 1)) ++face;
        edges.push_back({std::min(a, b), std::max(a, b), face, a < b});
      }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
      return std::tuple(a.low, a.high, a.ascends) < std::tuple(b.low, b.high, b.ascends);
    });
    for (size_t i = 0; i < edges.size();) {
      const Edge edge = edges[i];
      int surplus = 0;
      for (; i < edges.size() && edges[i].low == edge.low && edges[i].high == edge.high; ++i) {
        surplus += edges[i].ascends ? 1 : -1;
      }
      for (; surplus > 0; --surplus) sides_[edge.face].push_back({edge.high, edge.low});
      for (; surplus < 0; ++surplus) sides_[edge.face].push_back({edge.low, edge.high});
    }
  }

  /// The distance of a point of the outline from the face's first corner.
  double outline_distance(const FaceAxes& axes, Vec3d at) const {
    const double x = along(at, axes.u) - bound(axes.u, 0), y = along(at, axes.v) - bound(axes.v, 0);
    const double width = bound(axes.u, 1) - bound(axes.u, 0);
    const double height = bound(axes.v, 1) - bound(axes.v, 0);
    if (y == 0) return x;
    if (x == width) return width + y;
    if (y == height) return width + height + (width - x);
    return 2 * width + height + (height - y);
  }

  /// Finds the vertices on the outline of a face, where sides begin or end.
  Result<void> find_ends(int face) {
    const FaceAxes axes(face);
    auto& outline = outlines_[size_t(face)];
    std::vector<std::pair<uint32_t, int>> ends;
    for (const auto& [from, to] : sides_[size_t(face)]) {
      ends.push_back({from, -1});
      ends.push_back({to, 1});
    }
    std::sort(ends.begin(), ends.end());
    for (size_t i = 0; i < ends.size();) {
      const uint32_t vertex = ends[i].first;
      int surplus = 0;
      for (; i < ends.size() && ends[i].first == vertex; ++i) surplus += ends[i].second;
      if (surplus == 0) continue;
      const Vec3d at = mesh_.vertices.positions[vertex];
      const bool is_on_outline = faces_at(at) != 1u << face;
      if (!is_on_outline || surplus < -1 || surplus > 1) return tl::unexpected(not_closable());
      outline.push_back({outline_distance(axes, at), vertex, -1, surplus > 0});
    }
    std::sort(outline.begin(), outline.end(), [](const OutlinePoint& a, const OutlinePoint& b) {
      return std::tuple(a.distance, a.vertex) < std::tuple(b.distance, b.vertex);
    });
    for (size_t i = 0; i < outline.size(); ++i) {
      if (outline[i].begins == outline[(i + 1) % outline.size()].begins) {
        return tl::unexpected(not_closable());
      }
    }
    return {};
  }

  /// The corners of a face, counter-clockwise seen from outside, as points of its outline.
  std::array<OutlinePoint, 4> corners_of(const FaceAxes& axes) const {
    const double width = bound(axes.u, 1) - bound(axes.u, 0);
    const double height = bound(axes.v, 1) - bound(axes.v, 0);
    const int base = axes.side << axes.axis, u = 1 << axes.u, v = 1 << axes.v;
    return {OutlinePoint{0, 0, base}, OutlinePoint{width, 0, base | u},
            OutlinePoint{width + height, 0, base | u | v},
            OutlinePoint{2 * width + height, 0, base | v}};
  }

  /// Finds which corners of the box are above the isovalue.
  Result<void> find_corners() {
    for (int face = 0; face < 6; ++face) {
      const auto& outline = outlines_[size_t(face)];
      if (outline.empty()) continue;
      for (const OutlinePoint& corner : corners_of(FaceAxes(face))) {
        // The last end before the corner; the outline is cyclic.
        const OutlinePoint* last = &outline.back();
        for (const OutlinePoint& end : outline) {
          if (end.distance < corner.distance) last = &end;
        }
        auto& above = is_above_[size_t(corner.corner)];
        if (above.value_or(last->begins) != last->begins) return tl::unexpected(not_closable());
        above = last->begins;
      }
    }
    // The corners of a face whose outline the surface does not meet are on one side.
    for (int turn = 0; turn < 6; ++turn) {
      for (int face = 0; face < 6; ++face) {
        if (!outlines_[size_t(face)].empty()) continue;
        const auto corners = corners_of(FaceAxes(face));
        for (const OutlinePoint& from : corners) {
          const auto known = is_above_[size_t(from.corner)];
          for (const OutlinePoint& to : corners) {
            auto& above = is_above_[size_t(to.corner)];
            if (known && !above) above = known;
          }
        }
      }
    }
    // If the surface meets no edge of the box, all of them are on one side: inside, if the surface
    // with its caps encloses the complement of the solid.
    if (!is_above_[0]) is_above_.fill(enclosed_volume() < 0);
    for (int face = 0; face < 6; ++face) {
      if (!outlines_[size_t(face)].empty()) continue;
      const auto corners = corners_of(FaceAxes(face));
      for (const OutlinePoint& corner : corners) {
        if (is_above_[size_t(corner.corner)] != is_above_[size_t(corners[0].corner)]) {
          return tl::unexpected(not_closable());
        }
      }
    }
    return {};
  }

  /// By Gauss's theorem; the sides on faces are loops.
  double enclosed_volume() const {
    const auto& at = mesh_.vertices.positions;
    double six_volumes = 0;
    for (const auto& [a, b, c] : mesh_.triangles) {
      six_volumes += dot(at[a] - low_, cross(at[b] - low_, at[c] - low_));
    }
    for (const auto& sides : sides_) {
      for (const auto& [from, to] : sides) {
        const Vec3d first = at[sides.front().from] - low_;
        six_volumes += dot(first, cross(at[from] - low_, at[to] - low_));
      }
    }
    return six_volumes / 6;
  }

  uint32_t corner_vertex(int corner) {
    auto& vertex = corner_vertices_[size_t(corner)];
    if (!vertex) {
      vertex = static_cast<uint32_t>(mesh_.vertices.positions.size());
      mesh_.vertices.positions.push_back(
          {bound(0, corner & 1), bound(1, corner >> 1 & 1), bound(2, corner >> 2 & 1)});
      const auto outwards = [&](int axis) {
        return static_cast<float>((corner >> axis & 1) == 1 ? 1 : -1);
      };
      mesh_.vertices.normals.push_back({outwards(0), outwards(1), outwards(2)});
      // No cell of the surface is known to be there.
      for (auto& values : mesh_.vertices.fields) values.push_back(NAN);
    }
    return *vertex;
  }

  /// Adds the parts of the outline that are above the isovalue to the sides of a face.
  void append_outline(int face) {
    auto& outline = outlines_[size_t(face)];
    for (OutlinePoint corner : corners_of(FaceAxes(face))) {
      if (!*is_above_[size_t(corner.corner)]) continue;
      corner.vertex = corner_vertex(corner.corner);
      corner.begins = true;
      outline.push_back(corner);
    }
    std::sort(outline.begin(), outline.end(), [](const OutlinePoint& a, const OutlinePoint& b) {
      return std::tuple(a.distance, a.vertex) < std::tuple(b.distance, b.vertex);
    });
    for (size_t i = 0; i < outline.size(); ++i) {
      if (!outline[i].begins) continue;
      sides_[size_t(face)].push_back({outline[i].vertex, outline[(i + 1) % outline.size()].vertex});
    }
  }

  MeshPart& mesh_;
  const Vec3d low_, high_;
  std::array<std::vector<CapSide>, 6> sides_;
  std::array<std::vector<OutlinePoint>, 6> outlines_;
  std::array<std::optional<bool>, 8> is_above_;
  std::array<std::optional<uint32_t>, 8> corner_vertices_;
};

}  // namespace

bool is_closed(const MeshPart& mesh) {
  uint64_t sum = 0;
  for (const auto& triangle : mesh.triangles) {
    for (size_t i = 0; i < 3; ++i) {
      const uint64_t a = triangle[i], b = triangle[(i + 1) % 3];
      // The finalizer of splitmix64 (G. L. Steele, D. Lea, C. H. Flood, 2014).
      uint64_t hash = (std::min(a, b) << 32 | std::max(a, b)) + 0x9E3779B97F4A7C15u;
      hash = (hash ^ hash >> 30) * 0xBF58476D1CE4E5B9u;
      hash = (hash ^ hash >> 27) * 0x94D049BB133111EBu;
      hash ^= hash >> 31;
      sum += a < b ? hash : 0 - hash;
    }
  }
  return sum == 0;
}

Result<void> close_at_box(MeshPart& mesh, Vec3d low, Vec3d high) {
  if (mesh.triangles.empty()) return {};
  return BoxClosing(mesh, low, high).run();
}

}  // namespace isosplat
