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
#include "shared/import/volume/time_axis.h"
#include "shared/import/voxels/stored_voxels.h"

namespace isosplat::import {

/// The fields of a NIfTI-1 or NIfTI-2 header that the importer uses, in native byte order.
struct NiftiHeader {
  int version = 1;
  bool is_pair = false;  ///< the voxels are in the .img file beside the .hdr
  bool big_endian = false;
  std::vector<int64_t> sizes;  ///< field "dim", 1 to 7 sizes
  int16_t data_type = 0;
  int16_t bits = 0;
  std::array<double, 8> pixdim{};
  double voxel_offset = 0;
  double slope = 0, intercept = 0;
  int32_t qform_code = 0, sform_code = 0;
  std::array<double, 3> quaternion{};  ///< b, c, d
  std::array<double, 3> qoffset{};
  std::array<double, 12> srow{};  ///< row by row
  int32_t units = 0;              ///< xyzt_units
  double time_offset = 0;         ///< toffset
};

/// Size of a NIfTI-2 header in bytes; a NIfTI-1 header has 348.
constexpr size_t kNifti2Bytes = 540;

/// Parses the first bytes of a file: at least 348, or 540 for NIfTI-2. Errors: malformed_volume,
/// and unsupported_format for ANALYZE 7.5.
Result<NiftiHeader> parse_nifti(const std::filesystem::path& path,
                                std::span<const std::byte> bytes);

/// The error for an invalid header. `what`: what was expected and found.
tl::unexpected<Error> malformed_nifti(const std::filesystem::path& path, const std::string& what);

/// The voxel type of a data type code. Nothing for types that are not scalar or not supported.
std::optional<VoxelType> nifti_type(int16_t code);

/// The times of the steps along the fourth axis: from toffset on, at distances of pixdim[4]. If
/// xyzt_units has no unit of time, the result has no times: pixdim[4] is then often 1, or has
/// another meaning.
TimeAxis nifti_times(const NiftiHeader& header);

/// The geometry in LPS and millimetres: from the sform, else from the qform, else from the spacings
/// alone. Adds a note for each assumption. Errors: malformed_volume.
Result<HeaderGeometry> nifti_geometry(const std::filesystem::path& path, const NiftiHeader& header,
                                      std::vector<std::string>& notes);

}  // namespace isosplat::import
