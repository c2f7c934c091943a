#include "server/memory_limit.h"

#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

namespace isosplat {
namespace {

constexpr uint64_t kReserve = 16 << 20;

bool is_limited() {
  rlimit limit{};
  return ::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
}

}  // namespace

void prepare_for_memory_limit() {
  if (!is_limited()) return;
  constexpr int kHeaps = 2;
  constexpr size_t kStackBytes = 2 << 20;
  ::mallopt(M_ARENA_MAX, kHeaps);
  pthread_attr_t attributes;
  if (::pthread_getattr_default_np(&attributes) != 0) return;
  if (::pthread_attr_setstacksize(&attributes, kStackBytes) == 0) {
    ::pthread_setattr_default_np(&attributes);
  }
  ::pthread_attr_destroy(&attributes);
}

bool has_memory_for(uint64_t bytes) {
  if (!is_limited()) return true;
  const uint64_t all = bytes + kReserve;
  void* const tried =
      ::mmap(nullptr, all, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (tried == MAP_FAILED) return false;
  ::munmap(tried, all);
  return true;
}

}  // namespace isosplat
