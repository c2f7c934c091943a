#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace isosplat::import {

/// Decodes a picture of lossless JPEG (ITU T.81, annex H: process 14) with one component, as in
/// DICOM. `out`: its samples, with `columns` in each row. Returns the number of bits per sample, 2
/// to 16; 0 if the picture is damaged or has another size.
int decode_lossless_jpeg(std::span<const uint8_t> in, size_t columns, std::span<uint16_t> out);

}  // namespace isosplat::import
