#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "shared/import/volume/import_options.h"
#include "shared/import/volume/opened_volume.h"

namespace isosplat::import {

/// Millimetres per unit of length.
inline constexpr double kAngstrom = 1e-7;
inline constexpr double kBohr = 0.529177210903e-7;  ///< CODATA 2018

/// A grid whose values are numbers in a text file.
struct TextGrid {
  std::string format;            ///< for VolumeHeader
  Vec3<int64_t> voxels;          ///< the fastest axis first
  std::array<Vec3d, 3> steps{};  ///< from voxel to voxel along these axes
  Vec3d origin{0, 0, 0};         ///< of the first voxel
  double unit = 1;               ///< millimetres per unit of steps and origin
  uint64_t begin = 0;            ///< offset in the file where the values begin
  uint64_t components = 1;       ///< values of each voxel, one after another
  uint64_t component = 0;        ///< the one to read
  double slope = 1;              ///< factor of the values
  bool ends_with_file = true;    ///< more values are an error
};

/// Opens it; values are read in double precision, and in memory that does not depend on its size.
/// Errors: those of open_volume.
Result<OpenVolume> open_text_grid(const std::filesystem::path& path, const TextGrid& grid,
                                  const ImportOptions& options, std::vector<std::string> notes);

}  // namespace isosplat::import
