#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/import/geometry/orientation.h"

// The conventions of formats for positions in space. Isosplat uses the coordinates of DICOM:
// millimetres, x to the patient's left, y to the back, z to the head (LPS), right-handed. README.md
// in shared/import has a table of each format's conventions.
namespace isosplat::import {

/// The directions of a file's x, y and z axes.
enum class Frame {
  lps,  ///< left, posterior, superior; also any right-handed frame that does not refer to a patient
  ras,  ///< right, anterior, superior: x and y change sign
  las,  ///< left, anterior, superior, left-handed: y changes sign
  left_handed,  ///< left-handed, does not refer to a patient: z changes sign
};

/// A geometry from the step vector of each axis (from a voxel to the next one) and the centre of
/// the first voxel. The lengths become the spacing; a step in negative x, y or z becomes a
/// direction.
HeaderGeometry geometry_of_steps(const std::array<Vec3d, 3>& steps, Vec3d origin);

/// A geometry with the axes x, y and z. A negative spacing becomes a reversed direction.
HeaderGeometry geometry_of_spacing(Vec3d spacing, Vec3d origin);

/// Converts a geometry from `frame` to LPS.
void to_lps(Frame frame, HeaderGeometry& geometry);

/// Multiplies all lengths by a factor.
void scale_lengths(double factor, HeaderGeometry& geometry);

/// The axes of a unit cell, with length 1. x is parallel to the first axis, and z is perpendicular
/// to the first two. `angles`: between y and z, x and z, x and y, in degrees. Nothing if no cell
/// has these angles.
std::optional<std::array<Vec3d, 3>> cell_axes(const std::array<double, 3>& angles);

/// Millimetres per unit of length: "mm", "um", "µm", "micron", "metre", "inch", … Nothing for any
/// other text.
std::optional<double> millimetres_in(std::string_view unit);

/// Converts a geometry with lengths in `unit` to millimetres. An unknown unit leaves the geometry
/// unchanged and adds a note; an empty unit leaves it unchanged without a note.
void to_millimetres(std::string_view unit, HeaderGeometry& geometry,
                    std::vector<std::string>& notes);

/// The same for a spacing with a unit for each axis. Units that begin with "pixel" leave their axis
/// unchanged without a note.
void spacing_to_millimetres(const std::array<std::string, 3>& units, HeaderGeometry& geometry,
                            std::vector<std::string>& notes);

}  // namespace isosplat::import
