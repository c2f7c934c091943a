#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace isosplat {

/// XXH3-64 with seed 0.
uint64_t checksum64(std::span<const std::byte> bytes);

/// The checksum of a chunk or page in the directory: the low 32 bits of checksum64.
inline uint32_t checksum32(std::span<const std::byte> bytes) {
  return static_cast<uint32_t>(checksum64(bytes));
}

/// Computes a store's content id incrementally: XXH3-128 with seed 0, in its canonical (big-endian)
/// form.
class ContentHash {
 public:
  ContentHash();
  ContentHash(ContentHash&&) noexcept;
  ContentHash& operator=(ContentHash&&) noexcept;
  ~ContentHash();

  void add(std::span<const std::byte> bytes);
  std::array<uint8_t, 16> digest() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
