#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace isosplat::import {

/// Names for a message: "a, b and 3 more". `most`: the number of names before "and".
std::string name_list(const std::vector<std::string>& names, size_t most);

}  // namespace isosplat::import
