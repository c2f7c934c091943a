#pragma once

#include <array>

namespace isosplat {

/// The sRGB colour (0 … 1) of a CIE 1976 L*a*b* colour: L* from 0 to 100, for the white point D50,
/// which DICOM uses. It is adapted to D65 (Bradford). Colours outside sRGB are clamped.
std::array<float, 3> srgb_of_cie_lab(const std::array<double, 3>& lab);

}  // namespace isosplat
