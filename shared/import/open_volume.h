#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/grid/volume_source.h"
#include "shared/import/allowances.h"

namespace isosplat {

/// One of several volumes in a file: the options that choose it, and what tells it from the others.
struct VolumeChoice {
  std::string label = {};  ///< a text that tells it from the others
  std::string name = {};   ///< what the file calls it, and sizes: no words of ours. May be empty
  std::string dataset = {}, series = {}, segment = {};
  std::optional<int64_t> channel = {}, time_step = {};
  std::optional<Allowance> allowance = {};  ///< not another volume: a fault that is to be accepted
};

/// Options that complete or override the file's header.
struct ImportOptions {
  std::optional<Vec3<int64_t>> dims;  ///< raw files only: voxels along x, y, z
  std::optional<VoxelType> type;      ///< raw files only
  std::optional<bool> big_endian;     ///< raw files only; nothing: little-endian, with a note
  uint64_t skip_bytes = 0;            ///< raw files only: bytes before the first voxel
  std::optional<Vec3d> spacing;       ///< every format: overrides the header's spacing
  std::optional<int64_t> time_step;   ///< time step of a 4D volume, from 0
  /// DICOM: a series, by its number in messages or its UID. TIFF: an image, by its number in
  /// messages or its name.
  std::string series;
  std::optional<int64_t> channel;  ///< channel of a volume with several, from 0
  std::string segment;             ///< DICOM segmentations: a segment, by its number or label
  std::string dataset;             ///< HDF5: the path of a dataset
  uint64_t memory_bytes = uint64_t{1} << 30;  ///< memory limit of a reader's child process
  Allowances allowed;                         ///< every format: faults that are not errors

  /// Every format: voxels of this value are absent. The value is in the user's units, after slope
  /// and intercept.
  std::optional<double> missing_value;
  /// If missing_value is not set: whether voxels become absent that have a header's fill value, or
  /// a value that programs use for "no value", far outside the range of all others.
  bool finds_missing_values = true;

  /// If not null: is given the volumes among which these options do not choose. Where open_volume
  /// fails for that reason, each one's options, added to these, choose. If it succeeds, these are
  /// all that it could read, the one that it chose by itself included. Where an error advises an
  /// allowance, it is given that one. Must outlive the call of open_volume.
  std::vector<VolumeChoice>* choices = nullptr;
};

/// Values from `low` to `high` (usually equal) that stand for "no value" according to a file's
/// header. If the header is not reliable (in DICOM, padding is often the value of air), they become
/// absent only if they lie apart from all other values, and those are not labels.
struct FillValue {
  double low = 0, high = 0;
  bool is_certain = true;
};

/// An open volume, and notes about how it was read. Each note is one sentence: what was assumed,
/// ignored or filled, and, if useful, which option changes it. Notes are shown to the user and kept
/// in the store.
struct OpenVolume {
  std::unique_ptr<VolumeSource> source;
  std::vector<std::string> notes = {};
  /// The fill value of the file's header. Set by the readers of formats; open_volume applies it.
  std::optional<FillValue> fill_value = std::nullopt;
};

/// Opens a volume: NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI (.nii, .nii.gz), MRC (.mrc,
/// .map, .rec, also compressed), NumPy (.npy), HDF5, legacy VTK structured points (.vtk), TIFF (one
/// file with pages, or a folder with a file per slice), a folder of PNG, JPEG or JPEG 2000, DICOM
/// (a folder with a series, or a multi-frame file), or raw voxels (with dims and type in the
/// options, or both in the file's name, as in head_256x256x128_uint8.raw). A file of any of these
/// may be compressed as a whole by gzip, bzip2, xz or Zstandard. Reads only the header, and checks
/// it against the file's size if the file is not compressed.
///
/// The result is the volume that the file describes; or that volume with notes about assumptions;
/// or an error. Data that are missing, truncated or contradictory are an error unless
/// options.allowed contains the matching allowance. shared/import/README.md describes the
/// conventions of each format.
///
/// Errors: io_error, unsupported_format, unsupported_type, malformed_volume, truncated, no_cells,
/// volume_too_large, invalid_argument (options that do not fit the file). The message contains the
/// file, what was expected and found, and the remedy.
Result<OpenVolume> open_volume(const std::filesystem::path& path, const ImportOptions& options);

/// The format of a file by its first bytes and its name: "NRRD", "MetaImage", "NIfTI", "MRC",
/// "NumPy", "HDF5", "netCDF" (its classic format), "VTK", "TIFF", "DICOM", "raw" or "compressed";
/// empty if no reader takes it. Reads no headers: open_volume may still refuse it.
std::string_view format_of_file(const std::filesystem::path& path);

/// How a file is compressed as a whole, if open_volume unpacks it before its reader reads it:
/// "gzip", "bzip2", "xz" or "zstd"; else empty. In WebAssembly the caller unpacks it.
std::string_view packing_of_file(const std::filesystem::path& path);

/// The paths of the datasets of an HDF5 file that are volumes, in order. Errors: those of
/// open_volume.
Result<std::vector<std::string>> hdf5_datasets(const std::filesystem::path& path);

/// The volumes of a file that has several (HDF5: its datasets), in order. Empty if open_volume
/// needs no choice for this file. Errors: those of open_volume.
Result<std::vector<VolumeChoice>> volumes_in_file(const std::filesystem::path& path);

/// Parses a voxel type as the command line and raw file names write it: u8, uint8, uchar, i16,
/// int16, short, f32, float, … Nothing for an unknown name.
std::optional<VoxelType> voxel_type_of(std::string_view name);

}  // namespace isosplat
