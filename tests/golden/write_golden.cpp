// Writes the golden stores of a version of the format: write_golden FOLDER 1.0|1.1. To be run once
// for each version. The stores are kept for ever, and every later reader must read them.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <limits>
#include <stdexcept>

#include "native/builder/array_source.h"
#include "native/builder/store_with_fields.h"
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
std::vector<T> voxels_of(Index3 n, F value) {
  std::vector<T> voxels;
  for (int32_t z = 0; z < n.z; ++z) {
    for (int32_t y = 0; y < n.y; ++y) {
      for (int32_t x = 0; x < n.x; ++x) voxels.push_back(static_cast<T>(value(x, y, z)));
    }
  }
  return voxels;
}

VolumeGrid grid_of(Index3 n) {
  VolumeGrid grid;
  grid.voxels = n;
  grid.spacing = {0.5, 0.5, 2};
  grid.origin = {-10, 20, 0.25};
  return grid;
}

template <class T, class F>
void write(const std::filesystem::path& folder, const std::string& name, Index3 n, F value) {
  const auto voxels = voxels_of<T>(n, value);
  ArraySource<T> source(grid_of(n), voxels, name);
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

template <class T>
FieldInput field_of(const std::string& name, Index3 n, const std::vector<T>& voxels) {
  return {name, name, [=, &voxels]() -> Result<std::unique_ptr<VolumeSource>> {
            return std::make_unique<ArraySource<T>>(grid_of(n), voxels, name);
          }};
}

/// A store with a field of bytes, and one of numbers with missing values.
int write_fields(const std::filesystem::path& folder) {
  const Index3 n{66, 14, 12};
  Noise noise;
  const auto density = voxels_of<uint8_t>(
      n, [&](int x, int y, int z) { return 250 * bowl(x, y, z, n) + noise.next() % 4; });
  const auto phase = voxels_of<uint8_t>(n, [](int x, int y, int z) { return x + y / 2 + 3 * z; });
  const auto temperature = voxels_of<float>(n, [&](int x, int y, int z) {
    return x > 60 || noise.next() % 50 == 0 ? std::numeric_limits<double>::quiet_NaN()
                                            : 300 + 0.125 * bowl(y, x, z, n);
  });
  ArraySource<uint8_t> source(grid_of(n), density, "fields");
  const std::vector fields{field_of("phase", n, phase), field_of("temperature", n, temperature)};
  const auto path = folder / "fields.isosplat";
  if (const auto built = build_store_with_fields(source, fields, path, {}); !built) {
    throw std::runtime_error(built.error().message);
  }
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const std::string digest = digest_of(std::as_bytes(std::span(bytes)));
  std::ofstream(folder / "fields.txt") << digest;
  std::cout << "fields: " << bytes.size() << " bytes\n" << digest;
  return 0;
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
  const std::string version = count == 3 ? arguments[2] : "";
  if (version == "1.0") return isosplat::run(arguments[1]);
  return version == "1.1" ? isosplat::write_fields(arguments[1]) : 2;
}
