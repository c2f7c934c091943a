#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isosplat::fuzz {

/// Takes small numbers from a fuzzer's input; 0 when there are none left.
class Input {
 public:
  Input(const uint8_t* data, size_t size) : data_(data), size_(size) {}

  uint32_t number(int bytes) {
    uint32_t value = 0;
    for (int i = 0; i < bytes && size_ > 0; ++i, ++data_, --size_) value = value << 8 | *data_;
    return value;
  }
  bool empty() const { return size_ == 0; }
  std::span<const std::byte> rest() const {
    return {reinterpret_cast<const std::byte*>(data_), size_};
  }

 private:
  const uint8_t* data_;
  size_t size_;
};

/// Changes valid bytes as the input says, at most 16 places: what a random file never reaches, a
/// nearly valid one does. Each edit is a place (2 bytes) and what is written there (1 byte).
inline void edit(std::span<std::byte> bytes, Input& input) {
  for (int i = 0; i < 16 && !input.empty() && !bytes.empty(); ++i) {
    const size_t place = input.number(2) % bytes.size();
    bytes[place] = static_cast<std::byte>(input.number(1));
  }
}

}  // namespace isosplat::fuzz
