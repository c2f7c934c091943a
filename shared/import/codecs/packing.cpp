#include "shared/import/codecs/packing.h"

#include <string>

#include "shared/import/text/header_text.h"

namespace isosplat::import {

Packing packing_of(std::string_view beginning) {
  using namespace std::string_view_literals;
  if (beginning.starts_with("\x1f\x8b"sv)) return Packing::gzip;
  // "BZh", the size of blocks, and the first block or the end of an empty stream.
  if (beginning.size() >= 10 && beginning.starts_with("BZh") && beginning[3] >= '1' &&
      beginning[3] <= '9' &&
      (beginning.substr(4, 6) == "\x31\x41\x59\x26\x53\x59"sv ||
       beginning.substr(4, 6) == "\x17\x72\x45\x38\x50\x90"sv)) {
    return Packing::bzip2;
  }
  if (beginning.starts_with("\xfd\x37\x7a\x58\x5a\0"sv)) return Packing::xz;
  if (beginning.starts_with("\x28\xb5\x2f\xfd"sv)) return Packing::zstd;
  return Packing::none;
}

std::string_view name_of(Packing packing) {
  constexpr std::string_view kNames[] = {"", "gzip", "bzip2", "xz", "zstd"};
  return kNames[static_cast<size_t>(packing)];
}

std::filesystem::path unpacked_name(const std::filesystem::path& path) {
  const std::string suffix = lower_case(path.extension().string());
  for (const char* known : {".gz", ".bz2", ".xz", ".zst"}) {
    if (suffix == known) return path.stem();
  }
  return path.filename();
}

}  // namespace isosplat::import
