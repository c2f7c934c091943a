// Deflated data: the importer's decoder yields the same bytes as zlib, and ends in the same way.

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "shared/import/codecs/deflate_decoder.h"

namespace {

constexpr size_t kMostBytes = size_t{1} << 20;

struct Outcome {
  std::string bytes;
  bool is_whole = false;
};

Outcome with_zlib(const uint8_t* data, size_t size) {
  Outcome outcome;
  z_stream stream{};
  if (inflateInit2(&stream, -MAX_WBITS) != Z_OK) std::abort();
  outcome.bytes.resize(kMostBytes);
  stream.next_in = const_cast<Bytef*>(data);
  stream.avail_in = static_cast<uInt>(size);
  stream.next_out = reinterpret_cast<Bytef*>(outcome.bytes.data());
  stream.avail_out = static_cast<uInt>(kMostBytes);
  outcome.is_whole = inflate(&stream, Z_FINISH) == Z_STREAM_END;
  outcome.bytes.resize(stream.total_out);
  inflateEnd(&stream);
  return outcome;
}

Outcome with_own(const uint8_t* data, size_t size) {
  using Stop = isosplat::import::DeflateDecoder::Stop;
  Outcome outcome;
  isosplat::import::DeflateDecoder decoder(
      [&](std::span<uint8_t> bytes) -> isosplat::Result<size_t> {
        const size_t count = std::min({bytes.size(), size, size_t{7}});
        std::copy_n(data, count, bytes.data());
        data += count;
        size -= count;
        return count;
      });
  decoder.begin({});
  while (outcome.bytes.size() <= kMostBytes) {
    const Stop stop = decoder.run();
    outcome.bytes.append(reinterpret_cast<const char*>(decoder.made().data()),
                         decoder.made().size());
    decoder.take(decoder.made().size());
    if (stop == Stop::full || stop == Stop::block) continue;
    if (stop == Stop::damaged && std::string(decoder.damage()).empty()) std::abort();
    if (stop == Stop::failed) std::abort();  // the input can be read
    outcome.is_whole = stop == Stop::end;
    break;
  }
  return outcome;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const Outcome expected = with_zlib(data, size), found = with_own(data, size);
  if (expected.bytes.size() == kMostBytes) return 0;  // zlib stopped because its output was full
  if (found.is_whole != expected.is_whole) std::abort();
  if (found.is_whole && found.bytes != expected.bytes) std::abort();
  return 0;
}
