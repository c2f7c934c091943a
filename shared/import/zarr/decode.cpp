#include "shared/import/zarr/decode.h"

#include <blosc.h>
#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>

#include "shared/import/codecs/lzf.h"

namespace isosplat::import::zarr {
namespace {

using Bytes = std::vector<std::byte>;

/// Data between two codecs may have checksums and headers, and grow by them.
constexpr size_t kExtraBytes = 1024;

/// gzip or zlib. Nothing if the data are damaged or longer than `most`; the same below.
std::optional<Bytes> inflate_all(const Bytes& in, size_t most) {
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 32) != Z_OK) return std::nullopt;
  Bytes out(most);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(in.data()));
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int status = inflate(&stream, Z_FINISH);
  out.resize(out.size() - stream.avail_out);
  inflateEnd(&stream);
  if (status != Z_STREAM_END) return std::nullopt;
  return out;
}

std::optional<Bytes> decode_zstd(const Bytes& in, size_t most) {
  Bytes out(most);
  const size_t size = ZSTD_decompress(out.data(), out.size(), in.data(), in.size());
  if (ZSTD_isError(size)) return std::nullopt;
  out.resize(size);
  return out;
}

/// numcodecs writes the size before the block.
std::optional<Bytes> decode_lz4(const Bytes& in, size_t most) {
  if (in.size() < 4) return std::nullopt;
  size_t size = 0;
  for (size_t i = 4; i-- > 0;) size = size << 8 | static_cast<size_t>(in[i]);
  if (size > most) return std::nullopt;
  Bytes out(size);
  if (!decompress_lz4(std::span(in).subspan(4), out)) return std::nullopt;
  return out;
}

std::optional<Bytes> decode_blosc(const Bytes& in, size_t most) {
  size_t size = 0;
  if (in.size() < BLOSC_MIN_HEADER_LENGTH ||
      blosc_cbuffer_validate(in.data(), in.size(), &size) != 0 || size > most) {
    return std::nullopt;
  }
  Bytes out(size);
  const int decoded = blosc_decompress_ctx(in.data(), out.data(), out.size(), /*threads=*/1);
  if (decoded < 0 || static_cast<size_t>(decoded) != size) return std::nullopt;
  return out;
}

/// CRC-32C (RFC 3720, B.4), at the end of the data.
std::optional<Bytes> without_crc32c(Bytes in) {
  static const auto kTable = [] {
    std::array<uint32_t, 256> table{};
    for (uint32_t i = 0; i < 256; ++i) {
      uint32_t crc = i;
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0x82f63b78u : 0);
      table[i] = crc;
    }
    return table;
  }();
  if (in.size() < 4) return std::nullopt;
  const size_t size = in.size() - 4;
  uint32_t crc = ~uint32_t{0}, stated = 0;
  for (size_t i = 0; i < size; ++i) {
    crc = crc >> 8 ^ kTable[(crc ^ static_cast<uint32_t>(in[i])) & 0xff];
  }
  for (size_t i = 4; i-- > 0;) stated = stated << 8 | static_cast<uint32_t>(in[size + i]);
  if (~crc != stated) return std::nullopt;
  in.resize(size);
  return in;
}

/// The first bytes of all elements precede the second ones, and so on; a rest of less than an
/// element is unchanged.
Bytes unshuffled(const Bytes& in, size_t element_bytes) {
  const size_t count = in.size() / element_bytes;
  Bytes out(in);
  for (size_t byte = 0; byte < element_bytes; ++byte) {
    for (size_t i = 0; i < count; ++i) out[i * element_bytes + byte] = in[byte * count + i];
  }
  return out;
}

std::optional<Bytes> decoded_by(const Codec& codec, Bytes in, size_t most) {
  switch (codec.kind) {
    case Codec::Kind::gzip:
    case Codec::Kind::zlib:
      return inflate_all(in, most);
    case Codec::Kind::zstd:
      return decode_zstd(in, most);
    case Codec::Kind::lz4:
      return decode_lz4(in, most);
    case Codec::Kind::blosc:
      return decode_blosc(in, most);
    case Codec::Kind::crc32c:
      return without_crc32c(std::move(in));
    case Codec::Kind::shuffle:
      return unshuffled(in, static_cast<size_t>(codec.element_bytes));
  }
  return std::nullopt;
}

}  // namespace

Result<std::vector<std::byte>> decode_chunk(const std::vector<Codec>& codecs, Bytes stored,
                                            size_t bytes, const std::string& name) {
  for (size_t i = codecs.size(); i-- > 0;) {
    auto decoded = decoded_by(codecs[i], std::move(stored), bytes + kExtraBytes);
    if (!decoded) {
      return fail(Status::malformed_volume,
                  fmt::format("{}: expected compressed data of {} bytes, found damaged data: copy "
                              "or download the file again",
                              name, bytes));
    }
    stored = std::move(*decoded);
  }
  if (stored.size() != bytes) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected {} bytes of a chunk, found {}: the file is damaged", name,
                            bytes, stored.size()));
  }
  return stored;
}

}  // namespace isosplat::import::zarr
