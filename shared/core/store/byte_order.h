#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

namespace isosplat {

/// Little-endian fields of 1 to 8 bytes, unaligned. Every access states its width in bytes, because
/// the format has fields of 3 and 6 bytes.
inline uint64_t read_le(const std::byte* at, int bytes) {
  uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value |= static_cast<uint64_t>(at[i]) << (8 * i);
  return value;
}

inline void write_le(std::byte* at, int bytes, uint64_t value) {
  for (int i = 0; i < bytes; ++i) at[i] = static_cast<std::byte>(value >> (8 * i) & 0xff);
}

inline double read_f64(const std::byte* at) {
  const uint64_t bits = read_le(at, 8);
  double value;
  std::memcpy(&value, &bits, 8);
  return value;
}

inline void write_f64(std::byte* at, double value) {
  uint64_t bits;
  std::memcpy(&bits, &value, 8);
  write_le(at, 8, bits);
}

/// Reads consecutive fields. The caller must have checked that there are enough bytes.
class FieldReader {
 public:
  explicit FieldReader(const std::byte* at) : at_(at) {}
  uint8_t u8() { return static_cast<uint8_t>(next(1)); }
  uint16_t u16() { return static_cast<uint16_t>(next(2)); }
  uint32_t u24() { return static_cast<uint32_t>(next(3)); }
  uint32_t u32() { return static_cast<uint32_t>(next(4)); }
  uint64_t u48() { return next(6); }
  uint64_t u64() { return next(8); }
  double f64() {
    at_ += 8;
    return read_f64(at_ - 8);
  }

 private:
  uint64_t next(int bytes) {
    at_ += bytes;
    return read_le(at_ - bytes, bytes);
  }
  const std::byte* at_;
};

/// Appends consecutive fields.
class FieldWriter {
 public:
  explicit FieldWriter(std::vector<std::byte>& out) : out_(out) {}
  void field(int bytes, uint64_t value) {
    out_.resize(out_.size() + static_cast<size_t>(bytes));
    write_le(out_.data() + out_.size() - bytes, bytes, value);
  }
  void f64(double value) {
    out_.resize(out_.size() + 8);
    write_f64(out_.data() + out_.size() - 8, value);
  }

 private:
  std::vector<std::byte>& out_;
};

}  // namespace isosplat
