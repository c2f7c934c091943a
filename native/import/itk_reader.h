#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "native/import/orientation.h"
#include "native/import/stored_voxels.h"

namespace isosplat {

/// The formats that ITK reads for us.
enum class ItkFormat { nrrd, nifti, meta_image, vtk, dicom };

/// What ITK says of a file. Geometry is in LPS, as ITK has it.
struct ItkHeader {
  std::vector<int64_t> sizes;  ///< voxels along each axis of space (and time), fastest first
  HeaderGeometry geometry;     ///< of the first three axes
  StoredType type = StoredType::u8;
  int components = 1;  ///< numbers per voxel

  bool has_known_type = true;  ///< false: the file's type is none of StoredType
};

/// One file opened by ITK's ImageIO. All that ITK throws becomes an Error; what it prints is
/// dropped. Not for several threads at a time, as ITK's readers silence global streams.
class ItkReader {
 public:
  /// Reads the header. Errors: malformed_volume with ITK's reason, io_error.
  static Result<ItkReader> open(ItkFormat format, const std::filesystem::path& path);

  ItkReader(ItkReader&&) noexcept;
  ~ItkReader();

  const ItkHeader& header() const;

  /// Reads all voxels of all time steps, native-endian. `out` has exactly as many bytes as the
  /// header's sizes × components × stored_bytes(type). Errors: malformed_volume.
  Result<void> read_all(std::span<std::byte> out);

 private:
  struct State;
  explicit ItkReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// The files of one DICOM series, unsorted.
struct DicomSeries {
  std::string id;
  std::vector<std::string> files;
};

/// The series of a folder, the one with the most files first. Errors: malformed_volume.
Result<std::vector<DicomSeries>> list_dicom_series(const std::filesystem::path& folder);

}  // namespace isosplat
