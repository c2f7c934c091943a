// Measures the accuracy of the normals of extracted points, and the time of extraction with two
// threads. isosplat_point_normals STORE VOLUME ISOVALUE RUNS. Prints a line of JSON: angles to the
// gradient by central differences, and the seconds of each run, smooth and exact in turn.
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "native/extract/extract.h"
#include "tests/bench/need.h"
#include "tests/bench/render/reference_normals.h"
#include "tests/bench/render/volume.h"

namespace isosplat {
namespace {

struct Measured {
  std::vector<double> angles, seconds;
};

int run(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: isosplat_point_normals STORE VOLUME ISOVALUE RUNS\n");
    return 2;
  }
  const double isovalue = std::atof(argv[3]);
  const auto store = need(StoreFile::open(argv[1]));
  const TestVolume volume = load_volume(argv[2]);
  const Matrix3d dual = volume.grid.dual_edges();
  constexpr const char* kNames[] = {"smooth", "exact"};
  Measured measured[2];
  const auto extract = [&](bool smooth, const auto& write) {
    need(extract_points(*store, isovalue, {}, {0, 2, smooth}, write));
  };
  for (int i = 0; i < std::atoi(argv[4]); ++i) {
    for (const bool smooth : {true, false}) {
      const auto begin = std::chrono::steady_clock::now();
      extract(smooth, [](const PointArrays&) { return Result<void>{}; });
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      measured[smooth ? 0 : 1].seconds.push_back(seconds.count());
    }
  }
  for (const bool smooth : {true, false}) {
    extract(smooth, [&](const PointArrays& points) {
      for (size_t i = 0; i < points.positions.size(); ++i) {
        const Vec3d index = multiply_transposed(dual, points.positions[i] - volume.grid.origin);
        const Vec3f n = points.normals[i];
        // Normals point towards smaller values.
        measured[smooth ? 0 : 1].angles.push_back(
            angle(Vec3d{n.x, n.y, n.z} * -1, reference_gradient(volume, index)));
      }
      return Result<void>{};
    });
  }
  std::printf("{");
  for (size_t i = 0; i < 2; ++i) {
    Measured& m = measured[i];
    std::printf("%s\"%s\":{\"points\":%zu,\"median\":%.4f,\"p95\":%.4f,\"seconds\":[", i ? "," : "",
                kNames[i], m.angles.size(), percentile(m.angles, 0.5), percentile(m.angles, 0.95));
    for (size_t k = 0; k < m.seconds.size(); ++k) std::printf("%s%.6f", k ? "," : "", m.seconds[k]);
    std::printf("]}");
  }
  std::printf("}\n");
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int argc, char** argv) {
  return isosplat::run(argc, argv);
}
