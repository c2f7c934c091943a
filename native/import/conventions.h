#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "native/import/orientation.h"

// What formats mean by a place in the world. Isosplat's world is that of DICOM: millimetres, x to
// the patient's left, y to the back, z to the head (LPS), right-handed. README.md in this folder
// has the table of each format's conventions.
namespace isosplat {

/// The directions of a file's x, y and z.
enum class Frame {
  lps,          ///< left, posterior, superior; also any right-handed frame without a patient
  ras,          ///< right, anterior, superior: x and y change sign
  las,          ///< left, anterior, superior, left-handed: y changes sign
  left_handed,  ///< left-handed without a patient: z changes sign
};

/// A geometry from the step of each axis (from a voxel to the next one along it) and the centre of
/// the first voxel. Lengths become the spacing, so that a step against x, y or z is a direction.
HeaderGeometry geometry_of_steps(const std::array<Vec3d, 3>& steps, Vec3d origin);

/// A geometry whose axes are x, y and z. A negative spacing is a direction.
HeaderGeometry geometry_of_spacing(Vec3d spacing, Vec3d origin);

/// Turns a geometry that is given in `frame` into LPS.
void to_lps(Frame frame, HeaderGeometry& geometry);

/// Multiplies all lengths.
void scale_lengths(double factor, HeaderGeometry& geometry);

/// How many millimetres a unit of length has: "mm", "um", "µm", "micron", "metre", "inch", …
/// Nothing for any other text.
std::optional<double> millimetres_in(std::string_view unit);

/// Turns a geometry whose lengths are in `unit` into millimetres. A unit that is no unit of length
/// leaves it, with a note; empty is no unit, and no note.
void to_millimetres(std::string_view unit, HeaderGeometry& geometry,
                    std::vector<std::string>& notes);

}  // namespace isosplat
