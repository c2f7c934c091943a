#pragma once

#include <cstdio>
#include <cstdlib>
#include <type_traits>

#include "shared/core/base/status.h"
#include "tests/evidence/paradigms/paradigms.h"

namespace isosplat {

/// The value of a result; prints an error, and ends the program.
template <class T>
T expect(Result<T> result) {
  if (!result) {
    std::fprintf(stderr, "%s\n", result.error().message.c_str());
    std::exit(1);
  }
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// See Extraction::cells_hash. `cell`: index in level 0.
inline uint64_t hash_of(Index3 cell) {
  uint64_t hash = static_cast<uint64_t>(cell.x) | static_cast<uint64_t>(cell.y) << 21 |
                  static_cast<uint64_t>(cell.z) << 42;
  hash = (hash ^ hash >> 30) * 0xBF58476D1CE4E5B9;  // splitmix64
  hash = (hash ^ hash >> 27) * 0x94D049BB133111EB;
  return hash ^ hash >> 31;
}

inline uint64_t bytes_of(const PointArrays& points) {
  return points.positions.size() * sizeof(Vec3d) + points.normals.size() * sizeof(Vec3f);
}

std::unique_ptr<Extractor> make_store_extractor(Paradigm paradigm, const TestVolume& volume,
                                                const std::filesystem::path& folder,
                                                bool count_cells);
std::unique_ptr<Extractor> make_tree_extractor(Paradigm paradigm, const TestVolume& volume,
                                               bool count_cells);

}  // namespace isosplat
