#pragma once

#include <cstdint>

namespace isosplat {

/// Memory of this machine, or the limit of its control group if that is smaller, in bytes.
uint64_t machine_memory();

}  // namespace isosplat
