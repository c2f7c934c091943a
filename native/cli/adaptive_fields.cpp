#include "native/cli/adaptive_fields.h"

#include <fmt/format.h>

#include "native/builder/field_place.h"
#include "native/builder/source_path.h"
#include "native/cli/adaptive_building.h"
#include "native/cli/outputs.h"
#include "shared/core/adaptive/drawn_cells.h"
#include "shared/core/adaptive/level_source.h"
#include "shared/core/unstructured/values_on_leaves.h"
#include "shared/import/codecs/file_head.h"
#include "shared/import/vtk_amr/vtk_amr.h"
#include "shared/import/vtk_mesh/vtk_mesh.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

bool is_amr(const fs::path& path) {
  const auto head = import::read_head(path);
  return head && import::is_vtk_amr(head->bytes());
}

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
  return field_at_voxels(std::make_unique<OwnedLevel>(field, std::move(*source)), from, lattice,
                         memory_bytes);
}

}  // namespace

FieldInput AdaptiveField::input(uint32_t level, const VolumeGrid& lattice) const {
  if (!grid_) return field_inputs({&placed_, 1}, lattice).front();
  return {placed_.file.name, source_file_name(placed_.file.file),
          [name = placed_.file.name, grid = grid_, level, lattice, memory = memory_bytes_] {
            return open_level(name, grid, level, lattice, memory);
          }};
}

Result<std::vector<AdaptiveField>> open_adaptive_fields(
    std::span<const FieldFile> files, const fs::path& volume, const AdaptiveGrid& grid,
    const VolumeHeader& header, const fs::path& target, uint64_t memory_bytes,
    const std::function<void(const std::string&)>& tell) {
  std::vector<AdaptiveField> fields;
  for (const FieldFile& file : files) {
    if (!is_adaptive(file.file)) {
      VolumeGrid nodes = header.grid;
      nodes.voxels = grid.cells(0) + Index3{1, 1, 1};
      auto placed = place_fields({&file, 1}, nodes, target, tell);
      if (!placed) return tl::unexpected(placed.error());
      fields.emplace_back(std::move(placed->front()));
      continue;
    }
    if (is_amr(file.file) != is_amr(volume)) {
      return fail(Status::invalid_argument,
                  fmt::format("field '{}': expected a regular volume or a grid of the same kind as "
                              "the volume, found {}",
                              file.name, file.file.string()));
    }
    const uint64_t memory = memory_bytes / files.size();
    auto opened = is_amr(volume) ? import::open_vtk_amr(file.file, file.options, memory)
                                 : open_mesh_field(file, grid, header, memory);
    if (!opened) return tl::unexpected(opened.error());
    if (auto other = check_not_input(target, opened->files); !other) {
      return tl::unexpected(other.error());
    }
    if (auto drawn = choose_drawn_cells(opened->grid); !drawn) return tl::unexpected(drawn.error());
    for (const std::string& note : opened->notes) {
      tell(fmt::format("field '{}': {}", file.name, note));
    }
    fields.emplace_back(file,
                        std::make_shared<const FieldGrid>(
                            FieldGrid{std::move(opened->grid), std::move(opened->header)}),
                        memory);
  }
  return fields;
}

}  // namespace isosplat::cli
