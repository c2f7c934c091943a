#include "shared/import/codecs/checksums.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace isosplat::import {
namespace {

constexpr size_t kSlices = 8;

/// kTables[k][b]: the CRC of byte b, followed by k zeros ("slicing by eight", Kounavis and Berry,
/// A Systematic Approach to Building High Performance Software-based CRC Generators, 2005).
constexpr auto kTables = [] {
  std::array<std::array<uint32_t, 256>, kSlices> tables{};
  for (uint32_t b = 0; b < 256; ++b) {
    uint32_t crc = b;
    for (int i = 0; i < 8; ++i) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    tables[0][b] = crc;
  }
  for (size_t k = 1; k < kSlices; ++k) {
    for (size_t b = 0; b < 256; ++b) {
      tables[k][b] = tables[k - 1][b] >> 8 ^ tables[0][tables[k - 1][b] & 0xff];
    }
  }
  return tables;
}();

}  // namespace

uint32_t crc32(uint32_t crc, std::span<const uint8_t> bytes) {
  crc = ~crc;
  for (; bytes.size() >= kSlices; bytes = bytes.subspan(kSlices)) {
    std::array<uint32_t, 2> words;  // little-endian, as every machine that this runs on
    std::memcpy(words.data(), bytes.data(), kSlices);
    words[0] ^= crc;
    crc = 0;
    for (size_t i = 0; i < 4; ++i) {
      crc ^= kTables[7 - i][words[0] >> 8 * i & 0xff] ^ kTables[3 - i][words[1] >> 8 * i & 0xff];
    }
  }
  for (const uint8_t b : bytes) crc = crc >> 8 ^ kTables[0][(crc ^ b) & 0xff];
  return ~crc;
}

uint32_t adler32(uint32_t adler, std::span<const uint8_t> bytes) {
  constexpr uint32_t kPrime = 65521;
  constexpr size_t kBatch = 5552;  // as many as fit in 32 bits
  uint32_t a = adler & 0xffff, b = adler >> 16;
  while (!bytes.empty()) {
    const auto batch = bytes.first(std::min(kBatch, bytes.size()));
    for (const uint8_t byte : batch) {
      a += byte;
      b += a;
    }
    a %= kPrime;
    b %= kPrime;
    bytes = bytes.subspan(batch.size());
  }
  return b << 16 | a;
}

}  // namespace isosplat::import
