#include "shared/import/hdf5/checksums.h"

#include <algorithm>
#include <bit>

namespace isosplat::import {

uint32_t hdf5_lookup3(std::span<const std::byte> bytes) {
  uint32_t a = 0xdeadbeef + static_cast<uint32_t>(bytes.size()), b = a, c = a;
  const auto word = [&](size_t begin) {
    uint32_t value = 0;
    for (size_t i = begin; i < std::min(begin + 4, bytes.size()); ++i) {
      value |= static_cast<uint32_t>(bytes[i]) << 8 * (i - begin);
    }
    return value;
  };
  const auto rotated = [](uint32_t value, int by) { return std::rotl(value, by); };
  while (bytes.size() > 12) {
    a += word(0);
    b += word(4);
    c += word(8);
    a -= c, a ^= rotated(c, 4), c += b;
    b -= a, b ^= rotated(a, 6), a += c;
    c -= b, c ^= rotated(b, 8), b += a;
    a -= c, a ^= rotated(c, 16), c += b;
    b -= a, b ^= rotated(a, 19), a += c;
    c -= b, c ^= rotated(b, 4), b += a;
    bytes = bytes.subspan(12);
  }
  if (bytes.empty()) return c;
  a += word(0);
  b += word(4);
  c += word(8);
  c ^= b, c -= rotated(b, 14);
  a ^= c, a -= rotated(c, 11);
  b ^= a, b -= rotated(a, 25);
  c ^= b, c -= rotated(b, 16);
  a ^= c, a -= rotated(c, 4);
  b ^= a, b -= rotated(a, 14);
  c ^= b, c -= rotated(b, 24);
  return c;
}

uint32_t hdf5_fletcher32(std::span<const std::byte> bytes) {
  uint32_t sum1 = 0, sum2 = 0;
  const auto fold = [](uint32_t sum) { return (sum & 0xffff) + (sum >> 16); };
  const size_t words = bytes.size() / 2;
  // After 360 words, the sums may overflow.
  constexpr size_t kMostWords = 360;
  for (size_t begin = 0; begin < words; begin += kMostWords) {
    for (size_t i = begin; i < std::min(begin + kMostWords, words); ++i) {
      sum1 += static_cast<uint32_t>(bytes[2 * i]) << 8 | static_cast<uint32_t>(bytes[2 * i + 1]);
      sum2 += sum1;
    }
    sum1 = fold(sum1);
    sum2 = fold(sum2);
  }
  if (bytes.size() % 2 == 1) {
    sum1 += static_cast<uint32_t>(bytes.back()) << 8;
    sum2 += sum1;
    sum1 = fold(sum1);
    sum2 = fold(sum2);
  }
  return fold(sum2) << 16 | fold(sum1);
}

}  // namespace isosplat::import
