// Writes a volume with structure at all scales, in any size, as NRRD:
// isosplat_growth_volume fractal|turbulence SIZE FILE
// fractal: the Mandelbulb of `isosplat demo`, bytes. turbulence: doubles (turbulence.h).
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string_view>
#include <vector>

#include "native/demo/demo_volumes.h"
#include "native/demo/parallel_slices.h"
#include "tests/bench/growth/turbulence.h"

namespace isosplat {
namespace {

constexpr unsigned kThreads = 2;

bool write(std::FILE* file, std::span<const std::byte> bytes) {
  return std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
}

bool write_header(std::FILE* file, const char* type, int32_t size) {
  return std::fprintf(file,
                      "NRRD0004\ntype: %s\ndimension: 3\nsizes: %d %d %d\nspacings: 1 1 1\n"
                      "endian: little\nencoding: raw\n\n",
                      type, size, size, size) > 0;
}

/// Writes a few slices at a time, since the whole volume takes gigabytes.
bool write_turbulence(std::FILE* file, int32_t size) {
  const Turbulence turbulence(size);
  constexpr int32_t kSlices = 16;
  const auto width = static_cast<size_t>(size);
  std::vector<double> values(width * width * kSlices);
  for (int32_t first = 0; first < size; first += kSlices) {
    for_each_slice(kSlices, kThreads, [&](int32_t slice) {
      for (int32_t y = 0; y < size; ++y) {
        const size_t row = static_cast<size_t>(slice) * width + static_cast<size_t>(y);
        turbulence.row(y, first + slice, &values[row * width]);
      }
    });
    if (!write(file, std::as_bytes(std::span(values)))) return false;
  }
  return true;
}

int run(std::string_view kind, int32_t size, const char* path) {
  if (size < 32 || size > 4096 || (size & (size - 1)) != 0) {
    return std::fprintf(stderr, "expected a power of two from 32 to 4096, found %d\n", size), 2;
  }
  if (kind != "fractal" && kind != "turbulence") {
    return std::fprintf(stderr, "expected fractal or turbulence\n"), 2;
  }
  std::FILE* file = std::fopen(path, "wb");
  if (!file) return std::perror(path), 1;
  bool written = false;
  if (kind == "fractal") {
    const std::vector<uint8_t> values = mandelbulb(size, kThreads);
    written = write_header(file, "uint8", size) && write(file, std::as_bytes(std::span(values)));
  } else {
    written = write_header(file, "double", size) && write_turbulence(file, size);
  }
  if (std::fclose(file) == 0 && written) return 0;
  return std::perror(path), 1;
}

}  // namespace
}  // namespace isosplat

int main(int count, char** arguments) {
  if (count == 4) return isosplat::run(arguments[1], std::atoi(arguments[2]), arguments[3]);
  std::fprintf(stderr, "usage: isosplat_growth_volume fractal|turbulence SIZE FILE\n");
  return 2;
}
