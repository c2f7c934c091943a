#include "native/extract/npy_header.h"

#include <fmt/format.h>

namespace isosplat {

std::string npy_header(std::string_view dtype, std::string_view shape, size_t bytes) {
  constexpr std::string_view kMagic{"\x93NUMPY\x01\x00", 8};
  // magic, 2 bytes of length, then the dictionary, padded with blanks and ended by a line feed
  const size_t text_bytes = bytes - kMagic.size() - 2;
  std::string header(kMagic);
  header += static_cast<char>(text_bytes & 0xFF);
  header += static_cast<char>(text_bytes >> 8);
  header += fmt::format("{{'descr': {}, 'fortran_order': False, 'shape': {}, }}", dtype, shape);
  header.resize(bytes - 1, ' ');
  header += '\n';
  return header;
}

}  // namespace isosplat
