#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "native/builder/derived_source.h"
#include "shared/import/open_volume.h"

namespace isosplat::cli {

/// A volume that becomes a field, or from which the field follows.
struct FieldFile {
  std::string name;
  std::filesystem::path file;
  import::ImportOptions options;        ///< which of its volumes
  std::string function = {};            ///< how it follows: "gradient", "distance 3"; else empty
  std::optional<Derived> derived = {};  ///< from the volume of the store
  std::optional<std::vector<int64_t>> distance_to = {};  ///< these labels; empty: all but 0
  bool is_labels = false;                                ///< its values are categories
  std::filesystem::path table = {};  ///< of their names and colours; empty: that of the file
  /// Its voxels are taken for those of the volume, whatever the file states: --spacing changes the
  /// place of the volume, but not that of the field.
  bool takes_voxels = false;
};

/// The field that a text names: a volume ("temperature=t.nrrd"), of which "t=file.h5#/path" names a
/// dataset; what follows from the volume of the store ("g=@gradient", "c=@curvature"); the distance
/// from the labels of a volume, or from some of them ("d=@distance(seg.nrrd)",
/// "d=@distance(seg.nrrd,3,5)": DistanceSource); or a volume whose values are labels, with a table
/// of their names and colours or without ("p=@labels(atlas.nii.gz,table.csv)": read_label_table).
/// Of the import options, the time step, the memory and the allowances apply to files; to raw files
/// also their size and type. Errors: invalid_argument.
Result<FieldFile> parse_field_file(const std::string& text, const import::ImportOptions& options);

/// Opens the volume of a field, or the one derived from it. Errors: those of open_volume.
Result<import::OpenVolume> open_field_file(const FieldFile& file);

/// The values of a field by its opened volume, whose voxels lie on this grid, whatever the file
/// states: those of the volume, or the distances from its labels. Errors: those of
/// DistanceSource::create.
Result<std::unique_ptr<VolumeSource>> values_of_field(const FieldFile& file,
                                                      std::unique_ptr<VolumeSource> volume,
                                                      const VolumeGrid& grid);

}  // namespace isosplat::cli
