#pragma once

#include <cstddef>
#include <span>

namespace isosplat::import {

/// Decompresses one xz stream in memory, with liblzma and at most 256 MiB of its memory: native
/// only. Returns false if the data are damaged, or do not fill `out` exactly.
bool decompress_xz(std::span<const std::byte> in, std::span<std::byte> out);

}  // namespace isosplat::import
