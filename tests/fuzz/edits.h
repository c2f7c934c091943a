#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isosplat::fuzz {

/// Reads small numbers from a fuzzer's input; 0 after its end.
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

/// Applies up to 16 edits of the input to valid bytes. Nearly valid files reach code that random
/// files do not. An edit is an offset (2 bytes) and the new byte.
inline void edit(std::span<std::byte> bytes, Input& input) {
  for (int i = 0; i < 16 && !input.empty() && !bytes.empty(); ++i) {
    const size_t place = input.number(2) % bytes.size();
    bytes[place] = static_cast<std::byte>(input.number(1));
  }
}

}  // namespace isosplat::fuzz
