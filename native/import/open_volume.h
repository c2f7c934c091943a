#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "native/import/allowances.h"
#include "native/import/volume_source.h"

namespace isosplat {

/// What a person may say of a volume that its file does not, or says wrongly.
struct ImportOptions {
  std::optional<Vec3<int64_t>> dims;  ///< raw files only: voxels along x, y, z
  std::optional<VoxelType> type;      ///< raw files only
  bool big_endian = false;            ///< raw files only
  uint64_t skip_bytes = 0;            ///< raw files only: before the first voxel
  std::optional<Vec3d> spacing;       ///< every format: instead of the header's
  std::optional<int64_t> time_step;   ///< of a 4D volume, from 0
  std::string series;                 ///< DICOM: which, by its number in messages or its UID
  uint64_t memory_bytes = uint64_t{1} << 30;  ///< that a reader in a child process may take
  Allowances allowed;                         ///< every format: what would be an error otherwise

  /// Every format: voxels of this value have none. It is the value as users see it, after slope and
  /// intercept.
  std::optional<double> missing_value;
  /// Whether a header's fill value, or a single value far outside the range of all others, is taken
  /// for a voxel without a value where missing_value does not say so.
  bool finds_missing_values = true;
};

/// Values from `low` to `high`, which are most often the same, that a file's header says stand for
/// no value. Where it is not certain (in DICOM, where padding is often written as the value of
/// air), they are taken so only if they lie apart from all others.
struct FillValue {
  double low = 0, high = 0;
  bool is_certain = true;
};

/// An open volume, and what a person should know of how it was read. Each note is one sentence that
/// says what was assumed, left out or filled, and where it helps how to say otherwise. They are
/// shown, and kept in the store.
struct OpenVolume {
  std::unique_ptr<VolumeSource> source;
  std::vector<std::string> notes = {};
  /// What the file's header gives to voxels without one. open_volume has taken it into
  /// account; it is for readers of formats to fill in.
  std::optional<FillValue> fill_value = std::nullopt;
};

/// Opens a volume: NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI (.nii, .nii.gz), legacy VTK
/// structured points (.vtk), TIFF (one file with pages, or a folder with a file per slice), DICOM
/// (a folder with a series, or a multi-frame file), or raw voxels (with dims and type, or with
/// both in the file's name, as in head_256x256x128_uint8.raw). Reads the header only, and has
/// checked it against the file's size where the file is not compressed.
///
/// The result is the volume that the file describes; or that volume with notes that say what was
/// assumed; or an error. Data that are missing, cut off or contradict each other are an error
/// unless options.allowed has what names them. native/import/README.md has the conventions of each
/// format.
///
/// Errors: io_error, unsupported_format, unsupported_type, malformed_volume, truncated, no_cells,
/// volume_too_large, invalid_argument (options that do not fit the file); the message names the
/// file, what was expected and found, and the remedy.
Result<OpenVolume> open_volume(const std::filesystem::path& path, const ImportOptions& options);

/// The voxel type of a name as the command line and raw file names write it: u8, uint8, uchar, i16,
/// int16, short, f32, float, … Nothing for an unknown one.
std::optional<VoxelType> voxel_type_of(std::string_view name);

}  // namespace isosplat
