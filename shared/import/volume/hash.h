#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace isosplat::import {

/// XXH3-64 with seed 0.
uint64_t hash_of(std::string_view bytes);

/// hash_of as 16 hexadecimal digits.
std::string hash_text(std::string_view bytes);

}  // namespace isosplat::import
