#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "native/import/orientation.h"
#include "native/import/stored_voxels.h"

// What is read through ITK's ImageIO. ITK and the libraries below it throw, print and, on damaged
// files, abort: everything runs in a child process (isolated.h), and comes back as an Error.
namespace isosplat {

/// The formats that ITK reads for us.
enum class ItkFormat { nrrd, nifti, meta_image, vtk };

/// What ITK says of a file. Geometry is in LPS, as ITK has it.
struct ItkHeader {
  std::vector<int64_t> sizes;  ///< voxels along each axis of space (and time), fastest first
  HeaderGeometry geometry;     ///< of the first three axes
  StoredType type = StoredType::u8;
  int components = 1;          ///< numbers per voxel
  bool has_known_type = true;  ///< false: the file's type is none of StoredType
};

/// Reads the header of a file. Errors: malformed_volume with ITK's reason, io_error.
Result<ItkHeader> read_itk_header(ItkFormat format, const std::filesystem::path& path);

/// Reads all voxels (of all time steps) of a file, native-endian, in a child process that may take
/// `memory_bytes`. `header`: what read_itk_header gave; `out` has exactly itk_bytes(header) bytes.
/// Errors: malformed_volume, out_of_memory.
Result<void> read_itk_voxels(ItkFormat format, const std::string& file, const ItkHeader& header,
                             uint64_t memory_bytes, std::span<std::byte> out);

/// Bytes of all voxels of a file. Zero where the sizes are not possible.
uint64_t itk_bytes(const ItkHeader& header);

}  // namespace isosplat
