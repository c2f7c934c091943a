#include "native/extract/npy_header.h"

#include <fmt/format.h>

namespace isosplat {

std::string npy_header(std::string_view dtype, std::string_view shape) {
  constexpr std::string_view kMagic{"\x93NUMPY\x01\x00", 8};
  // magic, 2 bytes of length, then the dictionary, padded with blanks and ended by a line feed
  constexpr size_t kTextBytes = kNpyHeaderBytes - kMagic.size() - 2;
  static_assert(kNpyHeaderBytes % 64 == 0, "the format requires it");
  std::string header(kMagic);
  header += static_cast<char>(kTextBytes & 0xFF);
  header += static_cast<char>(kTextBytes >> 8);
  header += fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': {}, }}", dtype, shape);
  header.resize(kNpyHeaderBytes - 1, ' ');
  header += '\n';
  return header;
}

}  // namespace isosplat
