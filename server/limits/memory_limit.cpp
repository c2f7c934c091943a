#include "server/limits/memory_limit.h"

#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>

namespace isosplat::server {
namespace {

constexpr uint64_t kReserve = 16 << 20;

/// The limit of the address space; UINT64_MAX: none.
uint64_t address_space_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return UINT64_MAX;
  return limit.rlim_cur;
}

bool has_address_space_for(uint64_t bytes) {
  void* const tried =
      ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (tried == MAP_FAILED) return false;
  ::munmap(tried, bytes);
  return true;
}

}  // namespace

void prepare_for_memory_limit() {
  const uint64_t limit = address_space_limit();
  if (limit == UINT64_MAX) return;
  constexpr uint64_t kBytesPerHeap = 512 << 20, kMostHeaps = 64;
  constexpr size_t kStackBytes = 2 << 20;
  ::mallopt(M_ARENA_MAX,
            static_cast<int>(std::clamp<uint64_t>(limit / kBytesPerHeap, 1, kMostHeaps)));
  pthread_attr_t attributes;
  if (::pthread_getattr_default_np(&attributes) != 0) return;
  if (::pthread_attr_setstacksize(&attributes, kStackBytes) == 0) {
    ::pthread_setattr_default_np(&attributes);
  }
  ::pthread_attr_destroy(&attributes);
}

bool has_memory_for(uint64_t bytes) {
  if (address_space_limit() == UINT64_MAX) return true;
  if (has_address_space_for(bytes + kReserve)) return true;
  // Freed bytes stay in the heaps. They are usable for small allocations only.
  const uint64_t is_free = ::mallinfo2().fordblks;
  constexpr uint64_t kSmall = 1 << 20;
  return bytes <= kSmall ? is_free >= bytes + kReserve
                         : is_free >= kReserve && has_address_space_for(bytes);
}

}  // namespace isosplat::server
