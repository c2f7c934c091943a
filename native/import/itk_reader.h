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
enum class ItkFormat { nrrd, nifti, meta_image, vtk, dicom };

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

/// Reads the headers of several files, in their order. Errors: those of the first that fails.
Result<std::vector<ItkHeader>> read_itk_headers(ItkFormat format,
                                                std::span<const std::string> files);

/// Reads all voxels (of all time steps) of files one after the other, native-endian. `headers` are
/// those that read_itk_headers gave; `out` has exactly the bytes that they add up to. Errors:
/// malformed_volume, out_of_memory.
Result<void> read_itk_voxels(ItkFormat format, std::span<const std::string> files,
                             std::span<const ItkHeader> headers, std::span<std::byte> out);

/// Bytes of all voxels of a file. Zero where the sizes are not possible.
uint64_t itk_bytes(const ItkHeader& header);

/// The files of one DICOM series, unsorted.
struct DicomSeries {
  std::string id;
  std::vector<std::string> files;
};

/// The series of a folder, the one with the most files first. Errors: malformed_volume.
Result<std::vector<DicomSeries>> list_dicom_series(const std::filesystem::path& folder);

}  // namespace isosplat
