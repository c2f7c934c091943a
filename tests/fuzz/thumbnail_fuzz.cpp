// Pictures beside stores. The input is a file, and also the chunks of a WebP file with correct
// sizes and checksum.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "server/catalog/thumbnail.h"

namespace {

constexpr char kContent[] = "0123456789abcdef0123456789abcdef";

void append_number(std::string& webp, size_t number) {
  for (int shift = 0; shift < 32; shift += 8) webp += static_cast<char>(number >> shift);
}

/// Chunks from the input: type, length, data.
std::string webp_of(std::span<const uint8_t> input) {
  const auto take = [&](size_t count) {
    const auto taken = input.first(std::min(count, input.size()));
    input = input.subspan(taken.size());
    return std::string(taken.begin(), taken.end());
  };
  static const std::vector<std::string> types = {"VP8X", "ALPH", "VP8 ", "VP8L", "ISOS", "EXIF"};
  std::string chunks;
  while (!input.empty()) {
    const auto kind = static_cast<uint8_t>(take(1).front());
    const std::string length = take(1);
    std::string data = take(length.empty() ? 0 : static_cast<uint8_t>(length.front()));
    chunks += types[kind % types.size()];
    append_number(chunks, data.size());
    chunks += data;
    if (data.size() % 2 == 1) chunks += '\0';
  }
  chunks.resize(std::max<size_t>(chunks.size(), 18));  // VP8X, in which with_content_id inserts
  std::string webp = "RIFF";
  append_number(webp, chunks.size() + 4);
  return webp + "WEBP" + chunks;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::span<const uint8_t> input(data, size);
  isosplat::server::is_thumbnail(std::as_bytes(input), kContent);
  const std::string webp = webp_of(input);
  const auto named = isosplat::server::with_content_id(std::as_bytes(std::span(webp)), kContent);
  isosplat::server::is_thumbnail(named, kContent);
  return 0;
}
