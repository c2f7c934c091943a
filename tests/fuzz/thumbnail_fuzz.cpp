// Pictures beside stores. The input is a file, and also the chunks of a PNG with correct checksums.

#include <zlib.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "server/catalog/thumbnail.h"

namespace {

constexpr char kContent[] = "0123456789abcdef0123456789abcdef";

void append_number(std::string& png, uint32_t number) {
  for (int shift = 24; shift >= 0; shift -= 8) png += static_cast<char>(number >> shift);
}

void append_chunk(std::string& png, const std::string& type, const std::string& data) {
  append_number(png, static_cast<uint32_t>(data.size()));
  const std::string body = type + data;
  png += body;
  append_number(png, static_cast<uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(body.data()),
                                                 static_cast<uInt>(body.size()))));
}

/// The signature, IHDR and text of a thumbnail, and then chunks from the input: type, length, data.
std::string png_of(std::span<const uint8_t> input) {
  const auto take = [&](size_t count) {
    const auto taken = input.first(std::min(count, input.size()));
    input = input.subspan(taken.size());
    return std::string(taken.begin(), taken.end());
  };
  static const std::vector<std::string> types = {"IDAT", "IEND", "PLTE", "tRNS", "tEXt", "IHDR"};
  std::string png = "\x89PNG\r\n\x1a\n";
  append_chunk(png, "IHDR", take(13));
  append_chunk(png, "tEXt", std::string("Isosplat content\0", 17) + kContent);
  while (!input.empty()) {
    const auto kind = static_cast<uint8_t>(take(1).front());
    const std::string type = kind < types.size() ? types[kind] : take(4);
    const std::string length = take(1);
    const std::string data = take(length.empty() ? 0 : static_cast<uint8_t>(length.front()));
    append_chunk(png, type, data);
  }
  return png;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::span<const uint8_t> input(data, size);
  isosplat::server::is_thumbnail(std::as_bytes(input), kContent);
  const std::string png = png_of(input);
  isosplat::server::is_thumbnail(std::as_bytes(std::span(png)), kContent);
  return 0;
}
