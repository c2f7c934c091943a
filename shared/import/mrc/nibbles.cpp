#include "shared/import/mrc/nibbles.h"

#include <algorithm>
#include <limits>

namespace isosplat::import {
namespace {

class NibbleReader : public ByteReader {
 public:
  NibbleReader(std::unique_ptr<ByteReader> packed, uint64_t offset, uint64_t columns)
      : packed_(std::move(packed)), offset_(offset), columns_(columns) {}

  Result<void> read(uint64_t first, std::span<std::byte> out) override {
    while (!out.empty()) {
      const uint64_t row = first / columns_, column = first % columns_;
      const auto count = static_cast<size_t>(std::min<uint64_t>(out.size(), columns_ - column));
      bytes_.resize((column % 2 + count + 1) / 2);
      auto read = packed_->read(offset_ + row * row_bytes() + column / 2, bytes_);
      if (!read) return read;
      for (size_t i = 0; i < count; ++i) {
        const size_t at = column % 2 + i;
        out[i] = at % 2 == 0 ? bytes_[at / 2] & std::byte{15} : bytes_[at / 2] >> 4;
      }
      first += count;
      out = out.subspan(count);
    }
    return {};
  }

  bool is_random_access() const override { return packed_->is_random_access(); }
  uint64_t size_limit() const override { return voxels_in(packed_->size_limit()); }
  Result<uint64_t> count_after(uint64_t first, uint64_t max_count) override {
    const uint64_t begin = offset_ + first / columns_ * row_bytes() + first % columns_ / 2;
    const auto bytes = packed_->count_after(begin, max_count);
    if (!bytes) return bytes;
    return std::min(max_count, *bytes * 2);
  }
  uint64_t available_bytes() override { return voxels_in(packed_->available_bytes()); }
  uint64_t resident_bytes() const override { return packed_->resident_bytes(); }
  std::vector<std::filesystem::path> files() const override { return packed_->files(); }

 private:
  uint64_t row_bytes() const { return columns_ / 2 + columns_ % 2; }

  /// The number of voxels in a number of bytes of the file.
  uint64_t voxels_in(uint64_t bytes) const {
    const uint64_t packed = bytes - std::min(bytes, offset_);
    const uint64_t rows = packed / row_bytes(), rest = packed % row_bytes();
    uint64_t voxels = 0;
    if (__builtin_mul_overflow(rows, columns_, &voxels))
      return std::numeric_limits<uint64_t>::max();
    return voxels + std::min(2 * rest, columns_);
  }

  std::unique_ptr<ByteReader> packed_;
  uint64_t offset_, columns_;
  std::vector<std::byte> bytes_;
};

}  // namespace

std::unique_ptr<ByteReader> read_nibbles(std::unique_ptr<ByteReader> packed, uint64_t offset,
                                         uint64_t columns) {
  return std::make_unique<NibbleReader>(std::move(packed), offset, columns);
}

}  // namespace isosplat::import
