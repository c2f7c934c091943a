#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/base/vec3.h"

namespace isosplat {

/// A volume that Isosplat generates, for trying the program without other data.
struct DemoVolume {
  std::string_view name;   ///< also the file's name without extension
  std::string_view title;  ///< for display
  Index3 voxels;
  Vec3d spacing;
  std::vector<uint8_t> values;  ///< x fastest; the same bytes on every machine
};

/// "bucky", "marschner_lobb", "mandelbulb": in the order of lists.
std::span<const std::string_view> demo_names();

/// Generates a demo volume with up to `threads` (≥ 1) threads. Errors: not_found for an unknown
/// name.
Result<DemoVolume> make_demo(std::string_view name, unsigned threads);

/// The buckminsterfullerene C60 as a sum of Gaussians at its 60 atoms, 128³: the paper's "bucky
/// ball". The atoms are the vertices of a truncated icosahedron.
std::vector<uint8_t> bucky_ball(int32_t size, unsigned threads);

/// The test signal of Marschner and Lobb (1994) with f_M = 6 and α = 0.25 over [−1, 1]³.
std::vector<uint8_t> marschner_lobb(int32_t size, unsigned threads);

/// The logarithm of the distance to the Mandelbulb of power 8, by the usual estimate: an isovalue
/// is a shell around the fractal, and each higher one shows finer structure.
std::vector<uint8_t> mandelbulb(int32_t size, unsigned threads);

/// The header of an NRRD file of a demo volume (attached header, raw data); `values` follow it.
std::string demo_nrrd_header(const DemoVolume& volume);

}  // namespace isosplat
