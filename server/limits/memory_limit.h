#pragma once

#include <cstdint>

namespace isosplat::server {

// A process whose address space is limited (ulimit -v, LimitAS= of systemd) gets no memory above
// it. What is large is asked for first, so that what is small never lacks memory.

/// If there is a limit, threads get smaller stacks, and share few heaps, each of which reserves
/// 64 MiB. Call it before threads are started.
void prepare_for_memory_limit();

/// Whether so many bytes, and a reserve for all that is small, can be allocated now. Takes some
/// microseconds if there is a limit (more if little is left), else no time. Thread-safe.
bool has_memory_for(uint64_t bytes);

}  // namespace isosplat::server
