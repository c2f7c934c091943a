#include "shared/import/hdf5_filters.h"

#include <algorithm>
#include <cstring>

#include "shared/import/checksums.h"
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

Hdf5Decoder::Hdf5Decoder()
    : decoder_([this](std::span<uint8_t> into) -> Result<size_t> {
        const size_t count = std::min(into.size(), input_.size());
        if (count > 0) std::memcpy(into.data(), input_.data(), count);
        input_ = input_.subspan(count);
        return count;
      }) {}

bool Hdf5Decoder::inflate(std::span<const std::byte> stored, std::vector<std::byte>& out,
                          uint64_t bytes) {
  // Deflate expands at most 1032 times.
  constexpr uint64_t kMostExpansion = 1032;
  if (bytes / kMostExpansion > stored.size()) return false;
  input_ = stored;
  decoder_.reset();
  // RFC 1950: method 8, a multiple of 31, no dictionary.
  const int first = decoder_.byte(), second = decoder_.byte();
  if (second < 0 || (first * 256 + second) % 31 != 0 || (first & 15) != 8 || (second & 32) != 0) {
    return false;
  }
  decoder_.begin({});
  out.resize(static_cast<size_t>(bytes));
  size_t done = 0;
  for (;;) {
    const auto stop = decoder_.run();
    const auto made = decoder_.made();
    if (made.size() > out.size() - done) return false;
    if (!made.empty()) std::memcpy(out.data() + done, made.data(), made.size());
    done += made.size();
    decoder_.take(made.size());
    if (stop == DeflateDecoder::Stop::end) break;
    if (stop != DeflateDecoder::Stop::full && stop != DeflateDecoder::Stop::block) return false;
  }
  uint32_t stated = 0;
  for (int i = 0; i < 4; ++i) stated = stated << 8 | static_cast<uint32_t>(decoder_.byte() & 0xff);
  const std::span<const uint8_t> all(reinterpret_cast<const uint8_t*>(out.data()), out.size());
  return done == out.size() && stated == adler32(1, all);
}

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
      std::vector<std::byte> out;
      if (!inflate(stored, out, bytes)) {
        return file.malformed("the compressed data of a chunk are damaged");
      }
      stored = std::move(out);
    }
  }
  if (stored.size() != layout.chunk_bytes()) {
    return file.malformed("a chunk does not have the bytes of its elements");
  }
  return stored;
}

}  // namespace isosplat
