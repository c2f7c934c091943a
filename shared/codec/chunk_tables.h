#pragma once

#include <cstdint>

namespace isosplat {

/// Frequencies, of 4096, of the sixteen values of a quad of cells by its context (cell_mask.h):
/// where a quad's bits stand for 4³ cells each, and where they stand for one.
extern const uint16_t kBrickQuads[256][16];
extern const uint16_t kCellQuads[256][16];

/// Weights, in 1/128, of a corner's predictor by its class; their order is that of lattice.h.
inline constexpr int kTaps = 14;
inline constexpr int kClasses = 16;
extern const int16_t kDefaultWeights[kClasses][kTaps];

/// Frequencies, of 2048, of the 29 tokens of a residual (residual_model.h).
inline constexpr int kTokens = 29;
inline constexpr int kShapes = 54;
extern const uint16_t kTokenShapes[kShapes][kTokens];

}  // namespace isosplat
