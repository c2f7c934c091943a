#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "native/builder/resampled_source.h"
#include "native/builder/store_with_fields.h"
#include "native/cli/field_file.h"
#include "native/cli/scene_inputs.h"
#include "shared/import/open_volume.h"

// The fields of a build: --field temperature=t.nrrd.
namespace isosplat::cli {

/// The fields that texts name (parse_field_file), with different names. Those that follow from the
/// volume itself have this `volume`, if it is not empty. Errors: invalid_argument.
Result<std::vector<FieldFile>> field_files(std::span<const std::string> texts,
                                           const import::ImportOptions& options,
                                           const std::filesystem::path& volume = {});

/// The same for the steps of a scene: element s has the fields of step s. Derived fields name any
/// volume, since each of the step has its own. The text of a field names
/// as many files by a pattern ("t=t_*.nrrd", in natural order) or a list (t=steps.txt, as
/// listed_steps reads it, with the times of the scene), a file with as many time steps, or one
/// volume, which all steps have. Errors: those of field_files, listed_steps and volumes_of_file;
/// invalid_argument (another number of steps, or other times).
Result<std::vector<std::vector<FieldFile>>> field_files_of_steps(
    std::span<const std::string> texts, const import::ImportOptions& options,
    const SceneInputs& scene);

/// A field and the place of its voxels in the world of a store's volume.
struct PlacedField {
  FieldFile file;
  VolumeGrid grid;
  /// Identifies the content of the field without reading it, as a part of a key: its name, its
  /// choice of a volume, and the versions of its files.
  std::string version = {};
  std::vector<std::string> notes = {};
  std::vector<Category> categories = {};  ///< if its values are labels
  uint64_t memory_bytes = 0;              ///< while the field is read
};

struct PlaceOptions {
  std::filesystem::path target;  ///< the output, which must not be one of the files
  bool measures = true;          ///< how resampled fields differ from the fields, for a note
  bool has_place = false;        ///< see find_field_place
};

/// Reads the headers of fields for the volume on this grid. Calls `tell` with each note. Errors:
/// those of open_volume, find_field_place, field_categories, field_at_voxels and check_not_input;
/// out_of_memory if the field cannot be built within its memory.
Result<std::vector<PlacedField>> place_fields(std::span<const FieldFile> files,
                                              const VolumeGrid& grid, const PlaceOptions& options,
                                              const std::function<void(const std::string&)>& tell);

/// The fields for a store on this grid, which may be a part of the volume's grid, or reach beyond
/// it. Fields on other voxels are resampled.
std::vector<FieldInput> field_inputs(std::span<const PlacedField> fields, const VolumeGrid& grid,
                                     const ResamplingOptions& options = {});

/// build_store_file, with or without fields.
Result<BuildReport> build_with_fields(VolumeSource& source, std::span<const FieldInput> fields,
                                      const std::filesystem::path& target,
                                      const BuildOptions& options);

}  // namespace isosplat::cli
