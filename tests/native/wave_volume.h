#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "native/builder/array_source.h"
#include "native/builder/builder.h"

// Volumes in memory, for tests that compare stores with those of one build.
namespace isosplat::test {

/// Smooth waves with noise. Without noise, the store is far below its size limit; with much, the
/// limit changes the bands of most blocks.
template <class T>
std::vector<T> waves(Index3 n, double noise) {
  std::mt19937 random(7);
  std::vector<T> voxels;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) {
        const double wave = std::sin(0.11 * x) * std::cos(0.07 * y) * std::sin(0.05 * z + 1);
        const double u = static_cast<double>(random()) / 4294967295.0;
        voxels.push_back(static_cast<T>(100 * (1 + wave) * (1 - noise) + 200 * noise * u));
      }
    }
  }
  return voxels;
}

/// A volume of waves.
template <class T>
class Volume {
 public:
  explicit Volume(Index3 n, double noise = 0.02) : voxels_(waves<T>(n, noise)) { grid.voxels = n; }
  ArraySource<T> source() const { return {grid, std::span<const T>(voxels_)}; }
  std::string store(const BuildOptions& options = {}) const {
    ArraySource<T> volume = source();
    MemorySink sink;
    const auto built = build_store(volume, sink, options);
    EXPECT_TRUE(built) << built.error().message;
    return text(sink.bytes);
  }
  static std::string text(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }
  VolumeGrid grid;

 private:
  std::vector<T> voxels_;
};

}  // namespace isosplat::test
