#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace isosplat {

/// Calls work(z) once for each z in [0, slices), on up to `threads` threads.
template <class Work>
void for_each_slice(int32_t slices, unsigned threads, const Work& work) {
  std::atomic<int32_t> next{0};
  const auto run = [&] {
    for (int32_t z; (z = next.fetch_add(1)) < slices;) work(z);
  };
  std::vector<std::jthread> helpers;
  for (unsigned i = 1; i < std::max(1u, threads); ++i) helpers.emplace_back(run);
  run();
}

}  // namespace isosplat
