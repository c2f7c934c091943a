#include "shared/import/hdf5/filters.h"

#include <algorithm>

#include "shared/import/codecs/lzf.h"
#include "shared/import/hdf5/checksums.h"

namespace isosplat::import {
namespace {

/// Reverses the filter that stores the first byte of all elements, then the second of all, and so
/// on. Bytes that do not fill an element stay at the end.
std::vector<std::byte> unshuffled(std::span<const std::byte> bytes, size_t element) {
  std::vector<std::byte> out(bytes.begin(), bytes.end());
  const size_t count = bytes.size() / element;
  for (size_t i = 0; i < element; ++i) {
    const std::byte* from = bytes.data() + i * count;
    std::byte* to = out.data() + i;
    for (size_t k = 0; k < count; ++k) to[k * element] = from[k];
  }
  return out;
}

constexpr size_t kChecksumBytes = 4;

/// The filter LZ4: u64 bytes of all, u32 bytes of a block, then blocks: u32 bytes, content, which
/// is compressed if it is shorter than the block. Numbers are big-endian. False if they are
/// damaged.
bool decompress_lz4_blocks(std::span<const std::byte> in, std::span<std::byte> out) {
  const auto number = [&](size_t bytes) {
    uint64_t value = 0;
    const size_t count = std::min(bytes, in.size());
    for (size_t i = 0; i < count; ++i) value = value << 8 | static_cast<uint64_t>(in[i]);
    in = in.subspan(count);
    return value;
  };
  const uint64_t all = number(8), block = number(4);
  if (all != out.size() || block == 0) return false;
  while (!out.empty()) {
    const auto into = out.first(static_cast<size_t>(std::min<uint64_t>(block, out.size())));
    const uint64_t bytes = number(4);
    if (bytes > in.size()) return false;
    const auto from = in.first(static_cast<size_t>(bytes));
    if (from.size() == into.size()) {
      std::copy(from.begin(), from.end(), into.begin());
    } else if (!decompress_lz4(from, into)) {
      return false;
    }
    in = in.subspan(from.size());
    out = out.subspan(into.size());
  }
  return true;
}

}  // namespace

Result<std::vector<std::byte>> Hdf5Decoder::decode(const Hdf5File& file, const Hdf5Layout& layout,
                                                   std::vector<std::byte> stored, uint32_t mask) {
  const auto is_used = [&](size_t i) { return (mask >> i & 1) == 0; };
  for (size_t i = layout.filters.size(); i-- > 0;) {
    if (!is_used(i)) continue;
    if (layout.filters[i] == Hdf5Filter::shuffle) {
      if (layout.element_bytes > 1) {
        stored = unshuffled(stored, static_cast<size_t>(layout.element_bytes));
      }
    } else if (layout.filters[i] == Hdf5Filter::fletcher32) {
      if (stored.size() < kChecksumBytes) return file.malformed("a chunk is cut off");
      const std::span<const std::byte> all = stored;
      Hdf5Fields end = file.fields(all.last(kChecksumBytes));
      if (end.number(4) != hdf5_fletcher32(all.first(all.size() - kChecksumBytes))) {
        return file.malformed("the checksum of a chunk differs");
      }
      stored.resize(stored.size() - kChecksumBytes);
    } else {
      uint64_t bytes = layout.chunk_bytes();
      for (size_t k = 0; k < i; ++k) {
        if (is_used(k) && layout.filters[k] == Hdf5Filter::fletcher32) bytes += kChecksumBytes;
      }
      const auto damaged = [&] {
        return file.malformed("the compressed data of a chunk are damaged");
      };
      const Hdf5Filter filter = layout.filters[i];
      const uint64_t most =
          filter == Hdf5Filter::deflate ? kMostDeflateExpansion : uint64_t{kMostCopyExpansion};
      if (bytes / most > stored.size()) return damaged();
      std::vector<std::byte> out(static_cast<size_t>(bytes));
      bool is_right = false;
      if (filter == Hdf5Filter::lzf) {
        is_right = decompress_lzf(stored, out);
      } else if (filter == Hdf5Filter::lz4) {
        is_right = decompress_lz4_blocks(stored, out);
      } else {
        const std::span<const uint8_t> in(reinterpret_cast<const uint8_t*>(stored.data()),
                                          stored.size());
        const std::span<uint8_t> into(reinterpret_cast<uint8_t*>(out.data()), out.size());
        is_right = zlib_.inflate(in, into) == ZlibInflater::Outcome::exact;
      }
      if (!is_right) return damaged();
      stored = std::move(out);
    }
  }
  if (stored.size() != layout.chunk_bytes()) {
    return file.malformed("a chunk does not have the bytes of its elements");
  }
  return stored;
}

}  // namespace isosplat::import
