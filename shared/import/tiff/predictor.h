#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "shared/import/tiff/samples.h"

namespace isosplat::import {

/// Whether a predictor (tag 317) is supported for such samples: 1 (none), 2 (each sample is stored
/// as the difference from its left neighbour; TIFF 6.0, section 14), 3 (the same for the bytes of
/// floating-point numbers, sorted by significance; Adobe Photoshop TIFF Technical Note 3).
bool knows_predictor(uint64_t predictor, const TiffSamples& samples);

/// Converts rows to native-endian samples, as they were before prediction.
void undo_predictor(uint64_t predictor, const TiffSamples& samples, bool big_endian,
                    size_t row_bytes, std::span<std::byte> rows);

}  // namespace isosplat::import
