#pragma once

#include <array>
#include <cstdint>

namespace isosplat {

/// The colour of a label whose file states none: sRGB, 0 … 1. It depends on the value alone, so a
/// label has the same colour in all files. Consecutive values have clearly different colours: their
/// hues differ by the golden angle in the OKLCH colour space (B. Ottosson, 2020), and their
/// lightness takes turns.
std::array<float, 3> label_colour(int64_t value);

}  // namespace isosplat
