#include "shared/import/vtk_mesh/cell_division.h"

#include <algorithm>

namespace isosplat::import {
namespace {

using enum CellShape;

constexpr CellPart kTetrahedron[] = {{tetrahedron, {0, 1, 2, 3}}};
constexpr CellPart kHexahedron[] = {{hexahedron, {0, 1, 2, 3, 4, 5, 6, 7}}};
/// The corners of voxels are in the order of x, y, z.
constexpr CellPart kVoxel[] = {{hexahedron, {0, 1, 3, 2, 4, 5, 7, 6}}};
constexpr CellPart kWedge[] = {{wedge, {0, 1, 2, 3, 4, 5}}};
constexpr CellPart kPyramid[] = {{pyramid, {0, 1, 2, 3, 4}}};

/// Nodes 4 to 9 are in the middle of the edges 0–1, 1–2, 2–0, 0–3, 1–3 and 2–3. The octahedron
/// between them has the diagonals 4–9, 5–7 and 6–8.
constexpr CellPart kTetrahedra[3][8] = {
    {{tetrahedron, {0, 4, 6, 7}},
     {tetrahedron, {4, 1, 5, 8}},
     {tetrahedron, {6, 5, 2, 9}},
     {tetrahedron, {7, 8, 9, 3}},
     {tetrahedron, {4, 9, 5, 6}},
     {tetrahedron, {4, 9, 6, 7}},
     {tetrahedron, {4, 9, 7, 8}},
     {tetrahedron, {4, 9, 8, 5}}},
    {{tetrahedron, {0, 4, 6, 7}},
     {tetrahedron, {4, 1, 5, 8}},
     {tetrahedron, {6, 5, 2, 9}},
     {tetrahedron, {7, 8, 9, 3}},
     {tetrahedron, {5, 7, 4, 6}},
     {tetrahedron, {5, 7, 6, 9}},
     {tetrahedron, {5, 7, 9, 8}},
     {tetrahedron, {5, 7, 8, 4}}},
    {{tetrahedron, {0, 4, 6, 7}},
     {tetrahedron, {4, 1, 5, 8}},
     {tetrahedron, {6, 5, 2, 9}},
     {tetrahedron, {7, 8, 9, 3}},
     {tetrahedron, {6, 8, 4, 5}},
     {tetrahedron, {6, 8, 5, 9}},
     {tetrahedron, {6, 8, 9, 7}},
     {tetrahedron, {6, 8, 7, 4}}},
};
constexpr int8_t kDiagonals[3][2] = {{4, 9}, {5, 7}, {6, 8}};

/// The nodes of a hexahedron with 27 nodes, by x + 3 y + 9 z: the corners 0 to 7, the middles of
/// edges 8 to 19, those of the faces x = 0, x = 1, y = 0, y = 1, z = 0 and z = 1, and the centre.
constexpr int8_t kNodesOfHexahedron[27] = {0,  8,  1,  11, 24, 9,  3,  10, 2,   // z = 0
                                           16, 22, 17, 20, 26, 21, 19, 23, 18,  // z = 1/2
                                           4,  12, 5,  15, 25, 13, 7,  14, 6};  // z = 1

constexpr std::array<CellPart, 8> hexahedra() {
  std::array<CellPart, 8> parts{};
  for (int i = 0; i < 8; ++i) {
    const int first = (i & 1) + 3 * (i >> 1 & 1) + 9 * (i >> 2);
    constexpr int kOffsets[] = {0, 1, 4, 3, 9, 10, 13, 12};
    parts[static_cast<size_t>(i)].shape = hexahedron;
    for (size_t k = 0; k < 8; ++k) {
      parts[static_cast<size_t>(i)].corners[k] = kNodesOfHexahedron[first + kOffsets[k]];
    }
  }
  return parts;
}
constexpr std::array<CellPart, 8> kHexahedra = hexahedra();

/// Points 20 to 26 of a hexahedron.
constexpr CellPoint kPointsOfHexahedron[] = {
    {{0, 3, 4, 7}, {11, 15, 16, 19}, 4, 4},
    {{1, 2, 5, 6}, {9, 13, 17, 18}, 4, 4},
    {{0, 1, 4, 5}, {8, 12, 16, 17}, 4, 4},
    {{2, 3, 6, 7}, {10, 14, 18, 19}, 4, 4},
    {{0, 1, 2, 3}, {8, 9, 10, 11}, 4, 4},
    {{4, 5, 6, 7}, {12, 13, 14, 15}, 4, 4},
    {{0, 1, 2, 3, 4, 5, 6, 7}, {8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19}, 8, 12}};

/// Points 24 to 26 of a hexahedron that has nodes in the middle of four faces.
constexpr CellPoint kPointsOfBiquadratic[] = {
    kPointsOfHexahedron[4], kPointsOfHexahedron[5], {{16, 17, 18, 19}, {20, 21, 22, 23}, 4, 4}};

/// Nodes 6 to 11 of a wedge are in the middle of the edges of its triangles, 12 to 14 of those
/// between them, and 15 to 17 of its other faces.
constexpr CellPart kWedges[] = {{wedge, {0, 6, 8, 12, 15, 17}},   {wedge, {6, 1, 7, 15, 13, 16}},
                                {wedge, {8, 7, 2, 17, 16, 14}},   {wedge, {6, 7, 8, 15, 16, 17}},
                                {wedge, {12, 15, 17, 3, 9, 11}},  {wedge, {15, 13, 16, 9, 4, 10}},
                                {wedge, {17, 16, 14, 11, 10, 5}}, {wedge, {15, 16, 17, 9, 10, 11}}};
constexpr CellPoint kPointsOfWedge[] = {{{0, 1, 4, 3}, {6, 13, 9, 12}, 4, 4},
                                        {{1, 2, 5, 4}, {7, 14, 10, 13}, 4, 4},
                                        {{2, 0, 3, 5}, {8, 12, 11, 14}, 4, 4}};
/// A wedge whose edges between its triangles are linear.
constexpr CellPart kFlatWedges[] = {{wedge, {0, 6, 8, 3, 9, 11}},
                                    {wedge, {6, 1, 7, 9, 4, 10}},
                                    {wedge, {8, 7, 2, 11, 10, 5}},
                                    {wedge, {6, 7, 8, 9, 10, 11}}};

/// Nodes 5 to 8 of a pyramid are in the middle of the edges of its base, 9 to 12 of those at its
/// apex, and point 13 is in the middle of its base.
constexpr CellPart kPyramids[] = {{pyramid, {0, 5, 13, 8, 9}},    {pyramid, {5, 1, 6, 13, 10}},
                                  {pyramid, {13, 6, 2, 7, 11}},   {pyramid, {8, 13, 7, 3, 12}},
                                  {pyramid, {9, 10, 11, 12, 4}},  {pyramid, {9, 10, 11, 12, 13}},
                                  {tetrahedron, {5, 9, 10, 13}},  {tetrahedron, {6, 10, 11, 13}},
                                  {tetrahedron, {7, 11, 12, 13}}, {tetrahedron, {8, 12, 9, 13}}};
static_assert(std::size(kPyramids) == kMostParts);
constexpr CellPoint kPointsOfPyramid[] = {{{0, 1, 2, 3}, {5, 6, 7, 8}, 4, 4}};

}  // namespace

const CellDivision* division_of(int type) {
  static const std::array<CellDivision, 34> kDivisions = [] {
    std::array<CellDivision, 34> all{};
    all[10] = {4, {}, kTetrahedron};
    all[11] = {8, {}, kVoxel};
    all[12] = {8, {}, kHexahedron};
    all[13] = {6, {}, kWedge};
    all[14] = {5, {}, kPyramid};
    all[24] = {10, {}, kTetrahedra[0]};
    all[25] = {20, kPointsOfHexahedron, kHexahedra};
    all[26] = {15, kPointsOfWedge, kWedges};
    all[27] = {13, kPointsOfPyramid, kPyramids};
    all[29] = {27, {}, kHexahedra};
    all[31] = {12, {}, kFlatWedges};
    all[32] = {18, {}, kWedges};
    all[33] = {24, kPointsOfBiquadratic, kHexahedra};
    return all;
  }();
  if (type < 0 || type >= static_cast<int>(kDivisions.size())) return nullptr;
  const CellDivision& found = kDivisions[static_cast<size_t>(type)];
  return found.nodes > 0 ? &found : nullptr;
}

size_t add_divided(MeshBuilder& builder, int type, std::span<const uint32_t> nodes) {
  const CellDivision& division = *division_of(type);
  std::array<uint32_t, 28> all{};
  std::copy(nodes.begin(), nodes.end(), all.begin());
  size_t count = nodes.size();
  const auto indices = [&](const auto& numbers, size_t some, auto& out) {
    for (size_t i = 0; i < some; ++i) out[i] = all[static_cast<size_t>(numbers[i])];
    return std::span<const uint32_t>(out).first(some);
  };
  for (const CellPoint& point : division.points) {
    std::array<uint32_t, 8> corners{};
    std::array<uint32_t, 12> middles{};
    all[count++] = builder.add_point(indices(point.corners, point.corner_count, corners),
                                     indices(point.middles, point.middle_count, middles));
  }
  std::span<const CellPart> parts = division.parts;
  constexpr int kQuadraticTetrahedron = 24;
  if (type == kQuadraticTetrahedron) {
    const auto square = [&](size_t i) {
      const auto at = [&](size_t end) {
        return builder.mesh.points[all[static_cast<size_t>(kDiagonals[i][end])]];
      };
      const Vec3d along = at(1) - at(0);
      return dot(along, along);
    };
    size_t shortest = 0;
    for (size_t i = 1; i < 3; ++i) {
      if (square(i) < square(shortest)) shortest = i;
    }
    parts = kTetrahedra[shortest];
  }
  for (const CellPart& part : parts) {
    std::array<uint32_t, kMostCorners> corners{};
    builder.add_cell(part.shape,
                     indices(part.corners, static_cast<size_t>(corner_count(part.shape)), corners));
  }
  return parts.size();
}

}  // namespace isosplat::import
