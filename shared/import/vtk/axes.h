#pragma once

#include "shared/import/vtk/sections.h"

namespace isosplat::import {

/// Sets origin and spacing of a rectilinear grid from its coordinates. Returns the first axis along
/// which they are not evenly spaced: x, y or z; 0: none. Errors: those of reading;
/// malformed_volume for coordinates that are missing or have another number.
Result<char> place_vtk_axes(const std::filesystem::path& path, VtkFile& file);

/// Whether a file is a rectilinear grid whose coordinates can be read, are at least two along each
/// axis, and are not evenly spaced along one of them.
bool is_uneven_vtk_legacy(const std::filesystem::path& path);

}  // namespace isosplat::import
