#pragma once

#include <filesystem>

namespace isosplat::cli {

/// How the values of a file are arranged.
enum class GridKind : uint8_t {
  regular,       ///< on a regular grid, which open_volume() opens; also if the file is unknown
  adaptive,      ///< on refinement levels, which open_vtk_amr() opens
  unstructured,  ///< on a mesh, also a curvilinear or unevenly spaced one: open_vtk_mesh()
};

/// The kind of a file, by its beginning. Of rectilinear grids, the positions are read.
GridKind grid_kind(const std::filesystem::path& path);

}  // namespace isosplat::cli
