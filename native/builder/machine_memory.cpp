#include "native/builder/machine_memory.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>

namespace isosplat {

uint64_t machine_memory() {
  const uint64_t bytes = static_cast<uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                         static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
  uint64_t limit = 0;  // the file has "max" if there is none
  const bool has_limit = bool(std::ifstream("/sys/fs/cgroup/memory.max") >> limit) && limit > 0;
  return has_limit ? std::min(bytes, limit) : bytes;
}

}  // namespace isosplat
