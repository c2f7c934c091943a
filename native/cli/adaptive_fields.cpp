#include "native/cli/adaptive_fields.h"

#include <fmt/format.h>

#include <algorithm>

#include "native/builder/field_place.h"
#include "native/builder/source_path.h"
#include "native/cli/input_version.h"
#include "native/cli/outputs.h"
#include "shared/core/adaptive/drawn_cells.h"
#include "shared/core/adaptive/level_source.h"
#include "shared/core/unstructured/values_on_leaves.h"
#include "shared/import/vtk_amr/vtk_amr.h"
#include "shared/import/vtk_mesh/vtk_mesh.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

/// The values of a mesh at the leaf cells of a grid.
Result<import::OpenAdaptiveGrid> open_mesh_field(const FieldFile& file, const AdaptiveGrid& grid,
                                                 const VolumeHeader& header,
                                                 uint64_t memory_bytes) {
  auto opened = import::open_vtk_mesh(file.file, file.options, memory_bytes / 2);
  if (!opened) return tl::unexpected(opened.error());
  auto values = values_on_leaves(opened->mesh, grid, header.grid, memory_bytes / 2);
  if (!values) {
    return fail(values.error().status,
                fmt::format("{}: {}", file.file.string(), values.error().message));
  }
  return import::OpenAdaptiveGrid{std::move(*values), header, std::move(opened->notes),
                                  std::move(opened->files)};
}

/// A level of the field as a volume; owns the grid that it reads.
class OwnedLevel : public VolumeSource {
 public:
  OwnedLevel(std::shared_ptr<const FieldGrid> grid, LevelSource source)
      : grid_(std::move(grid)), source_(std::move(source)) {}

  const VolumeHeader& header() const override { return source_.header(); }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return source_.read_slices(first, count, out);
  }
  uint64_t resident_bytes() const override { return source_.resident_bytes(); }
  std::vector<fs::path> files() const override { return {}; }

 private:
  std::shared_ptr<const FieldGrid> grid_;
  LevelSource source_;
};

Result<std::unique_ptr<VolumeSource>> open_level(const std::string& name,
                                                 const std::shared_ptr<const FieldGrid>& field,
                                                 uint32_t level, const VolumeGrid& lattice,
                                                 uint64_t memory_bytes) {
  auto source = level < field->grid.levels()
                    ? LevelSource::create(field->grid, level, field->header)
                    : std::nullopt;
  if (!source) {
    return fail(Status::malformed_volume,
                fmt::format("field '{}': expected values on the refinement levels of the volume, "
                            "found none on level {}",
                            name, level));
  }
  const VolumeGrid from = source->header().grid;
  return field_at_voxels(name, std::make_unique<OwnedLevel>(field, std::move(*source)), from,
                         lattice, memory_bytes);
}

/// The share of the leaf cells of a grid that the grid of a field has.
double shared_leaves(const AdaptiveGrid& grid, const VolumeGrid& place, const FieldGrid& field) {
  const Vec3d edge = place.spacing, moved = field.header.grid.origin - place.origin;
  const double rounding = 1e-6 * std::min({edge.x, edge.y, edge.z});
  if (length(field.header.grid.spacing - edge) > rounding || length(moved) > rounding) return 0;
  uint64_t all = 0, found = 0;
  for (uint32_t level = 0; level < grid.levels(); ++level) {
    const bool has_level = level < field.grid.levels() &&
                           grid.cells_per_edge(0, level) == field.grid.cells_per_edge(0, level);
    for (const auto& [key, brick] : grid.bricks(level)) {
      for (size_t i = 0; i < kBrickVolume; ++i) {
        if (brick.states[i] != CellState::leaf) continue;
        ++all;
        found += has_level && field.grid.bricks(level).state(cell_of(brick, i)) == CellState::leaf;
      }
    }
  }
  return all > 0 ? static_cast<double>(found) / static_cast<double>(all) : 0;
}

}  // namespace

FieldInput AdaptiveField::input(uint32_t level, const VolumeGrid& lattice) const {
  if (!grid_) return field_inputs({&placed_, 1}, lattice).front();
  return {placed_.file.name, source_file_name(placed_.file.file),
          [file = placed_.file, grid = grid_, level, lattice] {
            return open_level(file.name, grid, level, lattice, file.options.memory_bytes);
          }};
}

Result<AdaptiveFields> open_adaptive_fields(std::span<const FieldFile> files, GridKind kind,
                                            const AdaptiveGrid& grid, const VolumeHeader& header,
                                            const fs::path& target, uint64_t memory_bytes,
                                            const std::function<void(const std::string&)>& tell) {
  AdaptiveFields opened_fields;
  for (const FieldFile& file : files) {
    const GridKind found = grid_kind(file.file);
    if (found == GridKind::regular) {
      VolumeGrid nodes = header.grid;
      nodes.voxels = grid.cells(0) + Index3{1, 1, 1};
      auto placed = place_fields({&file, 1}, nodes, {.target = target, .has_place = true}, tell);
      if (!placed) return tl::unexpected(placed.error());
      opened_fields.version += placed->front().version;
      opened_fields.fields.emplace_back(std::move(placed->front()));
      continue;
    }
    if (!file.function.empty()) {
      return fail(Status::invalid_argument,
                  fmt::format("field '{}': @{}: expected a regular volume, found the grid {}",
                              file.name, file.function, file.file.string()));
    }
    if (found != kind) {
      return fail(Status::invalid_argument,
                  fmt::format("field '{}': expected a regular volume or a grid of the same kind as "
                              "the volume, found {}",
                              file.name, file.file.string()));
    }
    const uint64_t memory = memory_bytes / files.size();
    auto opened = kind == GridKind::adaptive ? import::open_vtk_amr(file.file, file.options, memory)
                                             : open_mesh_field(file, grid, header, memory);
    if (!opened) return tl::unexpected(opened.error());
    if (auto other = check_not_input(target, opened->files); !other) {
      return tl::unexpected(other.error());
    }
    if (auto drawn = choose_drawn_cells(opened->grid); !drawn) return tl::unexpected(drawn.error());
    const auto field = std::make_shared<const FieldGrid>(
        FieldGrid{std::move(opened->grid), std::move(opened->header)});
    const double shared = shared_leaves(grid, header.grid, *field);
    if (shared == 0) {
      return fail(
          Status::invalid_argument,
          fmt::format("field '{}': expected cells at the places of the volume's cells, found "
                      "none in {}",
                      file.name, file.file.string()));
    }
    if (shared < 1) {
      opened->notes.push_back(
          fmt::format("{:.2g} % of the volume's cells have no value of it", 100 * (1 - shared)));
    }
    for (const std::string& note : opened->notes) {
      tell(fmt::format("field '{}': {}", file.name, note));
    }
    opened_fields.fields.emplace_back(file, field);
    opened_fields.version +=
        fmt::format("\n{} {} ", file.name, file.options.dataset) + input_versions(opened->files);
  }
  return opened_fields;
}

}  // namespace isosplat::cli
