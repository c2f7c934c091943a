#pragma once

#include <string>

#include "tests/native/test_volume.h"

namespace isosplat {

/// A volume file as quantized values in memory. Prints the error and exits with 1 if
/// the file cannot be read, or has a type that would be quantized.
TestVolume load_volume(const std::string& path);

/// Passes a mesh file of tests/evidence/peers/flying_edges_mesh.py to the renderer. Returns the
/// number of triangles.
uint64_t show_mesh(render::Renderer& renderer, const VolumeGrid& grid, const std::string& path);

}  // namespace isosplat
