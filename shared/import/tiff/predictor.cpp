#include "shared/import/tiff/predictor.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

namespace isosplat::import {
namespace {

/// Adds to each number its left neighbour, `stride` numbers before it.
template <class Word>
void add_left(size_t stride, std::span<std::byte> row) {
  for (size_t i = stride * sizeof(Word); i + sizeof(Word) <= row.size(); i += sizeof(Word)) {
    Word left, word;
    std::memcpy(&left, row.data() + i - stride * sizeof(Word), sizeof left);
    std::memcpy(&word, row.data() + i, sizeof word);
    word = static_cast<Word>(word + left);
    std::memcpy(row.data() + i, &word, sizeof word);
  }
}

void add_left(size_t bytes, size_t stride, std::span<std::byte> row) {
  if (bytes == 1) return add_left<uint8_t>(stride, row);
  if (bytes == 2) return add_left<uint16_t>(stride, row);
  if (bytes == 4) return add_left<uint32_t>(stride, row);
  return add_left<uint64_t>(stride, row);
}

/// A row has the highest bytes of all samples, then the next lower ones, and so on, in files of
/// both byte orders.
void join_bytes(size_t bytes, std::span<std::byte> row, std::vector<std::byte>& copy) {
  copy.assign(row.begin(), row.end());
  const size_t count = row.size() / bytes;
  for (size_t byte = 0; byte < bytes; ++byte) {
    const size_t to = std::endian::native == std::endian::little ? bytes - 1 - byte : byte;
    for (size_t i = 0; i < count; ++i) row[i * bytes + to] = copy[byte * count + i];
  }
}

void to_native_order(size_t bytes, bool big_endian, std::span<std::byte> rows) {
  if (bytes < 2 || big_endian == (std::endian::native == std::endian::big)) return;
  for (size_t i = 0; i + bytes <= rows.size(); i += bytes) {
    std::reverse(rows.data() + i, rows.data() + i + bytes);
  }
}

}  // namespace

bool knows_predictor(uint64_t predictor, const TiffSamples& samples) {
  const unsigned bits = samples.bits;
  if (predictor == 2) return bits == 8 || bits == 16 || bits == 32 || bits == 64;
  return predictor == 1 || (predictor == 3 && samples.is_float);
}

void undo_predictor(uint64_t predictor, const TiffSamples& samples, bool big_endian,
                    size_t row_bytes, std::span<std::byte> rows) {
  if (samples.bits % 8 != 0) return;
  const size_t bytes = samples.bits / 8;
  if (predictor != 3) to_native_order(bytes, big_endian, rows);
  if (predictor == 1) return;
  std::vector<std::byte> copy;
  for (size_t at = 0; at + row_bytes <= rows.size(); at += row_bytes) {
    const auto row = rows.subspan(at, row_bytes);
    add_left(predictor == 2 ? bytes : 1, samples.per_pixel, row);
    if (predictor == 3) join_bytes(bytes, row, copy);
  }
}

}  // namespace isosplat::import
