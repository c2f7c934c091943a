#pragma once

#include <cstdint>

namespace isosplat::server {

// The address space of a process may be limited (ulimit -v, LimitAS= of systemd). The server checks
// large allocations before it begins the work, so that small allocations do not fail.

/// If there is a limit, sets smaller stacks for threads, and few heaps that threads share, since
/// each heap reserves 64 MiB. Call it before threads are started.
void prepare_for_memory_limit();

/// Returns whether this many bytes can be allocated now, in addition to a reserve for small
/// allocations. Takes some microseconds if there is a limit (more if little is left), else no time.
/// Thread-safe.
bool has_memory_for(uint64_t bytes);

}  // namespace isosplat::server
