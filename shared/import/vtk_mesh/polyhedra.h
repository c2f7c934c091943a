#pragma once

#include "shared/import/vtk_mesh/mesh_builder.h"

namespace isosplat::import {

/// The faces of a polyhedron: for each the number of its corners, and their points in order around
/// it.
using FaceStream = std::span<const uint32_t>;

/// The faces of a pentagonal or hexagonal prism (VTK's types 15 and 16) with these corners.
std::vector<uint32_t> prism_faces(std::span<const uint32_t> corners);

/// Divides a polyhedron around its centre, the mean of its corners: a tetrahedron for each
/// triangle, a pyramid for each face of four corners, and tetrahedra around the centre of each
/// other face, the mean of its corners. So the function on a face follows from its corners alone,
/// and neighbours share it: on four corners it is the bilinear one, as that of hexahedra, wedges
/// and pyramids. Cells that are not star-shaped around their centre are divided into parts that
/// overlap. Returns the number of parts.
size_t add_polyhedron(MeshBuilder& builder, FaceStream faces);

/// The bytes that add_polyhedron() needs at most, from the length of the stream.
uint64_t polyhedron_bytes(uint64_t stream);

/// Whether a stream has `count` faces, at least 4, of at least 3 corners each.
bool is_polyhedron(FaceStream faces, size_t count);

}  // namespace isosplat::import
