#include "shared/import/hdf5_filters.h"

#include "shared/import/hdf5_checksums.h"

namespace isosplat {
namespace {

/// The filter stores the first byte of all elements, then the second of all, and so on. What does
/// not fill an element stays at the end.
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
      if (bytes / kMostDeflateExpansion > stored.size()) return damaged();
      std::vector<std::byte> out(static_cast<size_t>(bytes));
      const std::span<const uint8_t> in(reinterpret_cast<const uint8_t*>(stored.data()),
                                        stored.size());
      const std::span<uint8_t> into(reinterpret_cast<uint8_t*>(out.data()), out.size());
      if (zlib_.inflate(in, into) != ZlibInflater::Outcome::exact) return damaged();
      stored = std::move(out);
    }
  }
  if (stored.size() != layout.chunk_bytes()) {
    return file.malformed("a chunk does not have the bytes of its elements");
  }
  return stored;
}

}  // namespace isosplat
