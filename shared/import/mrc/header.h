#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/import/geometry/orientation.h"

namespace isosplat::import {

constexpr size_t kMrcBytes = 1024;

/// The fields of an MRC header that Isosplat uses. Arrays by file axis have the columns (fastest),
/// rows and sections; arrays by cell axis have x, y and z of the unit cell.
struct MrcHeader {
  bool big_endian = false;
  bool has_map_text = true;           ///< "MAP ": files from before 2000 lack it
  bool is_stamp_right = true;         ///< the machine stamp has the byte order of the numbers
  std::array<int32_t, 3> size{};      ///< by file axis: NX, NY, NZ
  int32_t mode = 0;                   ///< the type of the voxels
  std::array<int32_t, 3> start{};     ///< by file axis: NXSTART, NYSTART, NZSTART
  std::array<int32_t, 3> sampling{};  ///< by cell axis: MX, MY, MZ
  std::array<double, 3> cell{};       ///< by cell axis: lengths in ångström
  std::array<double, 3> angles{};  ///< alpha (between y and z), beta (x, z), gamma (x, y), degrees
  std::array<int32_t, 3> axis_of{};  ///< by file axis: 1, 2 or 3 for x, y or z of the cell
  double least = 0, greatest = 0;    ///< DMIN, DMAX
  bool has_skew = false;             ///< LSKFLG: a matrix rotates or moves the map (CCP4)
  int32_t space_group = 0;           ///< 0: images; 1: a volume; 401 and more: several volumes
  int32_t extended_bytes = 0;        ///< NSYMBT: bytes between this header and the voxels
  int32_t version = 0;               ///< NVERSION: 20140 and more since MRC2014
  bool is_imod = false;              ///< written by IMOD or a program that has its flags
  int32_t imod_flags = 0;
  std::array<double, 3> origin{};  ///< by cell axis, ångström
};

/// Reads a header of kMrcBytes bytes. Nothing if it is not an MRC header: without "MAP ", or with
/// numbers that are invalid in both byte orders. `by_name`: "MAP " is not required.
std::optional<MrcHeader> parse_mrc(std::span<const std::byte> bytes, bool by_name);

/// Positions of the voxels in millimetres. Adds notes about properties that the header leaves
/// undefined. Errors: malformed_volume for impossible axes or cells.
Result<HeaderGeometry> mrc_geometry(const std::filesystem::path& path, const MrcHeader& header,
                                    std::vector<std::string>& notes);

/// The error of a header that contradicts itself.
tl::unexpected<Error> malformed_mrc(const std::filesystem::path& path, const std::string& what);

}  // namespace isosplat::import
