#include "native/cli/field_inputs.h"

#include <fmt/format.h>

#include <cmath>

#include "native/builder/field_build.h"
#include "native/builder/source_path.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "shared/core/store/field_sections.h"

namespace isosplat::cli {
namespace {

struct NamedFile {
  std::string name, file, dataset;
};

Result<NamedFile> parse(const std::string& text) {
  const size_t equals = text.find('=');
  if (equals == text.npos || equals + 1 == text.size()) {
    return fail(Status::invalid_argument,
                fmt::format("--field: expected a name and a volume, such as "
                            "temperature=temperature.nrrd, found '{}'",
                            text));
  }
  NamedFile named{text.substr(0, equals), text.substr(equals + 1), {}};
  FieldInfo field;
  field.name = named.name;
  if (auto checked = check_field(field); !checked) return tl::unexpected(checked.error());
  std::error_code ignored;
  const size_t hash = named.file.rfind('#');
  if (hash != named.file.npos && !std::filesystem::exists(named.file, ignored)) {
    named.dataset = named.file.substr(hash + 1);
    named.file.resize(hash);
  }
  return named;
}

/// Whether two grids of the same size put their last voxels at different places: by more than a
/// hundredth of a voxel, or the first ones.
bool is_elsewhere(const VolumeGrid& a, const VolumeGrid& b) {
  const Vec3d last{a.voxels.x - 1.0, a.voxels.y - 1.0, a.voxels.z - 1.0};
  const double voxel = std::min({a.spacing.x, a.spacing.y, a.spacing.z});
  return !(length(a.origin - b.origin) <= voxel / 100 &&
           length(a.world(last) - b.world(last)) <= voxel / 100);
}

}  // namespace

Result<std::vector<FieldInput>> field_inputs(std::span<const std::string> texts,
                                             const import::ImportOptions& import_options,
                                             const VolumeGrid& grid,
                                             const std::filesystem::path& target) {
  std::vector<FieldInput> fields;
  for (const std::string& text : texts) {
    const auto named = parse(text);
    if (!named) return tl::unexpected(named.error());
    import::ImportOptions options;
    options.dataset = named->dataset;
    options.time_step = import_options.time_step;
    options.memory_bytes = import_options.memory_bytes;
    options.allowed = import_options.allowed;
    auto opened = import::open_volume(named->file, options);
    if (!opened) return tl::unexpected(opened.error());
    const VolumeGrid& found = opened->source->header().grid;
    if (auto same = check_field_grid(named->name, grid.voxels, found.voxels); !same) {
      return tl::unexpected(same.error());
    }
    if (auto other = check_not_input(target, opened->source->files()); !other) {
      return tl::unexpected(other.error());
    }
    for (std::string& each : opened->notes) note(fmt::format("field '{}': {}", named->name, each));
    if (is_elsewhere(grid, found)) {
      note(
          fmt::format("field '{}': its file places it elsewhere than the volume; its voxels are "
                      "taken for those of the volume",
                      named->name));
    }
    fields.push_back({named->name, source_file_name(named->file),
                      [file = named->file, options]() -> Result<std::unique_ptr<VolumeSource>> {
                        auto again = import::open_volume(file, options);
                        if (!again) return tl::unexpected(again.error());
                        return std::move(again->source);
                      },
                      opened->notes});
  }
  return fields;
}

}  // namespace isosplat::cli
