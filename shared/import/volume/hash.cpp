#include "shared/import/volume/hash.h"

#include <fmt/format.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace isosplat::import {

uint64_t hash_of(std::string_view bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::string hash_text(std::string_view bytes) {
  return fmt::format("{:016x}", hash_of(bytes));
}

}  // namespace isosplat::import
