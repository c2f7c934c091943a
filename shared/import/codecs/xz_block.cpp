#include "shared/import/codecs/xz_block.h"

#include <lzma.h>

#include <cstdint>

namespace isosplat::import {

bool decompress_xz(std::span<const std::byte> in, std::span<std::byte> out) {
  uint64_t memory = uint64_t{256} << 20;
  size_t read = 0, written = 0;
  const auto status = lzma_stream_buffer_decode(
      &memory, 0, nullptr, reinterpret_cast<const uint8_t*>(in.data()), &read, in.size(),
      reinterpret_cast<uint8_t*>(out.data()), &written, out.size());
  return status == LZMA_OK && read == in.size() && written == out.size();
}

}  // namespace isosplat::import
