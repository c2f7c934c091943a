#pragma once

#include <functional>
#include <memory>

#include "native/cli/field_inputs.h"
#include "native/cli/grid_kind.h"
#include "shared/core/adaptive/adaptive_grid.h"

// The fields of the stores of an adaptive grid.
namespace isosplat::cli {

/// An adaptive grid with the values of a field.
struct FieldGrid {
  AdaptiveGrid grid;
  VolumeHeader header;  ///< as OpenAdaptiveGrid has it
};

/// A field for the levels of an adaptive grid.
class AdaptiveField {
 public:
  /// The field of a regular volume, which each level resamples.
  explicit AdaptiveField(PlacedField placed) : placed_(std::move(placed)) {}
  /// The field of an adaptive grid whose drawn cells are chosen.
  AdaptiveField(const FieldFile& file, std::shared_ptr<const FieldGrid> grid)
      : placed_{file, {}}, grid_(std::move(grid)) {}

  /// The field for the store of a level with this lattice.
  FieldInput input(uint32_t level, const VolumeGrid& lattice) const;

 private:
  PlacedField placed_;
  std::shared_ptr<const FieldGrid> grid_;  ///< null: of a regular volume
};

/// The fields of an adaptive grid.
struct AdaptiveFields {
  std::vector<AdaptiveField> fields;
  std::string version;  ///< as PlacedField has it, of all
};

/// Opens fields for an adaptive grid, which is resolved: regular volumes, or grids of the same
/// kind, usually other arrays of its own file. `kind`: the grid's. `memory_bytes`: limit of
/// the memory of all. Calls `tell` with each note, also about leaf cells that a field does not
/// have. Errors: those of place_fields, open_vtk_amr, open_vtk_mesh, values_on_leaves and
/// check_not_input; invalid_argument for other kinds of grids, and for a field without any of the
/// leaf cells.
Result<AdaptiveFields> open_adaptive_fields(std::span<const FieldFile> files, GridKind kind,
                                            const AdaptiveGrid& grid, const VolumeHeader& header,
                                            const std::filesystem::path& target,
                                            uint64_t memory_bytes,
                                            const std::function<void(const std::string&)>& tell);

}  // namespace isosplat::cli
