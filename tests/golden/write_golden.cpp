// Writes the golden stores of this version of the format: write_golden FOLDER. To be run once for
// each version. The stores are kept for ever, and every later reader must read them.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <stdexcept>

#include "native/builder/array_source.h"
#include "tests/golden/digest.h"

namespace isosplat {
namespace {

/// The same numbers on every machine.
class Noise {
 public:
  uint32_t next() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<uint32_t>(state_ >> 33);
  }

 private:
  uint64_t state_ = 1;
};

template <class T, class F>
void write(const std::filesystem::path& folder, const std::string& name, Index3 n, F value) {
  std::vector<T> voxels;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) voxels.push_back(static_cast<T>(value(x, y, z)));
    }
  }
  VolumeGrid grid;
  grid.voxels = n;
  grid.spacing = {0.5, 0.5, 2};
  grid.origin = {-10, 20, 0.25};
  ArraySource<T> source(grid, voxels, name);
  MemorySink sink;
  BuildOptions options;
  options.fetch_weight = 1.8;
  if (const auto built = build_store(source, sink, options); !built) {
    throw std::runtime_error(built.error().message);
  }
  std::ofstream(folder / (name + ".isosplat"), std::ios::binary)
      .write(reinterpret_cast<const char*>(sink.bytes.data()),
             static_cast<std::streamsize>(sink.bytes.size()));
  std::ofstream(folder / (name + ".txt")) << digest_of(sink.bytes);
  std::cout << name << ": " << sink.bytes.size() << " bytes\n" << digest_of(sink.bytes);
}

/// A paraboloid with ripples, 0 to about 1. Uses only operations that all machines round alike.
double bowl(int32_t x, int32_t y, int32_t z, Index3 n) {
  const double u = 2.0 * x / n.x - 1, v = 2.0 * y / n.y - 1, w = 2.0 * z / n.z - 1;
  return (u * u + v * v + w * w) / 3 + ((x ^ y ^ z) & 7) / 64.0;
}

int run(const std::filesystem::path& folder) {
  write<uint8_t>(folder, "tiny", {3, 3, 3}, [](int x, int y, int z) { return 16 * x + 4 * y + z; });
  const Index3 a{70, 34, 12}, b{24, 20, 33}, c{20, 18, 17}, d{18, 12, 10};
  Noise noise;
  write<uint8_t>(folder, "u8", a, [&](int x, int y, int z) {
    return 250 * bowl(x, y, z, a) * (z > 5) + noise.next() % 4;
  });
  write<int16_t>(folder, "i16", b, [&](int x, int y, int z) {
    return 3000 * bowl(x, y, z, b) - 1000 + noise.next() % 64;
  });
  write<float>(folder, "f32_missing", c, [&](int x, int y, int z) {
    return noise.next() % 50 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                  : 0.125 * bowl(x, y, z, c);
  });
  write<uint32_t>(folder, "u32", d,
                  [&](int x, int y, int z) { return 4e9 * bowl(x, y, z, d) / 1.2; });
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int count, char** arguments) {
  return count == 2 ? isosplat::run(arguments[1]) : 2;
}
