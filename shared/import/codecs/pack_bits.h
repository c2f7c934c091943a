#pragma once

#include <cstdint>
#include <span>

namespace isosplat::import {

/// Expands PackBits data (TIFF 6.0, section 9; PS3.5, annex G) until `out` is full, and ignores the
/// rest. Returns false if the data end before.
bool expand_pack_bits(std::span<const uint8_t> in, std::span<uint8_t> out);

}  // namespace isosplat::import
