#include "native/cli/field_inputs.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <set>

#include "native/builder/field_build.h"
#include "native/builder/field_place.h"
#include "native/builder/source_path.h"
#include "native/cli/field_categories.h"
#include "native/cli/input_version.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "shared/core/store/format.h"
#include "shared/import/slices/slice_files.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

/// Parses texts, whose names must be different. Derived fields are those of `volume`.
Result<std::vector<FieldFile>> parse_all(std::span<const std::string> texts,
                                         const import::ImportOptions& options,
                                         const fs::path& volume) {
  std::vector<FieldFile> fields;
  std::set<std::string> names;
  for (const std::string& text : texts) {
    auto field = parse_field_file(text, options);
    if (!field) return tl::unexpected(field.error());
    if (!names.insert(field->name).second || names.size() > kMaxFields) {
      return fail(
          Status::invalid_argument,
          fmt::format("--field: expected at most {} fields with different names, found more, "
                      "or two with the name '{}'",
                      kMaxFields, field->name));
    }
    if (field->derived && volume.empty()) {
      return fail(
          Status::invalid_argument,
          fmt::format("field '{}': expected a file, since nothing can be derived from labels "
                      "and adaptive grids, found {}",
                      field->name, text));
    }
    if (field->derived) {
      field->file = volume;
      field->options = options;
      field->takes_voxels = false;
    }
    fields.push_back(std::move(*field));
  }
  return fields;
}

bool is_pattern(const fs::path& file) {
  std::error_code ignored;
  return file.string().find('*') != std::string::npos && !fs::exists(file, ignored);
}

bool is_list(const fs::path& file) {
  return file.extension() == ".txt";
}

/// Whether times are no more than the numbers of steps.
bool are_indices(std::span<const double> times) {
  for (size_t i = 0; i < times.size(); ++i) {
    if (times[i] != static_cast<double>(i)) return false;
  }
  return true;
}

/// The files whose names match a pattern, in natural order.
std::vector<fs::path> matching_files(const std::string& pattern) {
  glob_t found{};
  std::vector<fs::path> files;
  if (glob(pattern.c_str(), 0, nullptr, &found) == 0) {
    files.assign(found.gl_pathv, found.gl_pathv + found.gl_pathc);
  }
  globfree(&found);
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return import::natural_order(a.string(), b.string());
  });
  return files;
}

/// The volumes of a field, one for each step of the scene, or a single one for all.
Result<std::vector<SceneInput>> volumes_of_field(const FieldFile& field, const SceneInputs& scene) {
  const std::string text = field.file.string();
  if (is_pattern(field.file)) {
    std::vector<fs::path> files = matching_files(text);
    if (files.empty()) {
      return fail(Status::io_error, fmt::format("field '{}': expected files such as {}, found none",
                                                field.name, text));
    }
    SceneInputs steps = files_as_steps(std::move(files), field.options);
    if (steps.times.size() == scene.times.size() && steps.times != scene.times &&
        !are_indices(steps.times) && !are_indices(scene.times)) {
      note(
          fmt::format("field '{}': the names of its files have other numbers than the times of the "
                      "steps: they are taken in their order",
                      field.name));
    }
    return std::move(steps.volumes);
  }
  const bool is_a_list = is_list(field.file);
  auto volumes = is_a_list ? listed_steps(field.file, field.options)
                           : volumes_of_file(field.file, field.options);
  if (!volumes) return tl::unexpected(volumes.error());
  if (volumes->layers.size() > 1) {
    return fail(
        Status::invalid_argument,
        fmt::format("field '{}': expected one scalar at each voxel, found {} channels: save "
                    "one of them to a file",
                    field.name, volumes->layers.size()));
  }
  if (is_a_list && volumes->times != scene.times) {
    return fail(
        Status::invalid_argument,
        fmt::format("field '{}': expected the {} times of the scene, {} to {}, found other "
                    "times in {}",
                    field.name, scene.times.size(), scene.times.front(), scene.times.back(), text));
  }
  return std::move(volumes->volumes);
}

/// Finds the place of a field, and a note about it.
Result<FieldPlace> place_of(const FieldFile& file, const VolumeGrid& grid, const VolumeGrid& found,
                            bool has_place) {
  if (!file.takes_voxels) return find_field_place(file.name, grid, found, has_place);
  auto same = check_field_grid(file.name, grid.voxels, found.voxels);
  if (!same) return tl::unexpected(same.error());
  return FieldPlace{grid, true};
}

std::string version_of(const FieldFile& field, const VolumeSource& source) {
  std::vector<fs::path> files = source.files();
  if (!field.table.empty()) files.push_back(field.table);
  return fmt::format("\n{} {} {} {} {}", field.name, field.options.dataset,
                     field.options.time_step.value_or(-1), field.function, input_versions(files));
}

Result<void> check_memory(const FieldFile& file, const VolumeSource& source) {
  BuildOptions options;
  options.threads = 1;
  const uint64_t needed = min_memory(source, options), found = file.options.memory_bytes;
  if (needed <= found) return {};
  return fail(Status::out_of_memory,
              fmt::format("field '{}': expected a memory limit of at least {} MiB, found {} MiB: "
                          "raise it (--memory)",
                          file.name, (needed >> 20) + 1, found >> 20));
}

/// The values of a field at the voxels of a grid. `volume`: the opened one of the field.
Result<std::unique_ptr<VolumeSource>> at_voxels(const PlacedField& field,
                                                std::unique_ptr<VolumeSource> volume,
                                                const VolumeGrid& to, ResamplingOptions options) {
  auto values = values_of_field(field.file, std::move(volume), field.grid);
  if (!values) return values;
  options.nearest = field.file.is_labels;
  return field_at_voxels(field.file.name, std::move(*values), field.grid, to,
                         field.file.options.memory_bytes, options);
}

Result<PlacedField> place(const FieldFile& file, const VolumeGrid& grid,
                          const PlaceOptions& options) {
  auto opened = open_field_file(file);
  if (!opened) return tl::unexpected(opened.error());
  if (auto other = check_not_input(options.target, opened->source->files()); !other) {
    return tl::unexpected(other.error());
  }
  const Index3 voxels = opened->source->header().grid.voxels;
  const auto found = place_of(file, grid, opened->source->header().grid, options.has_place);
  if (!found) return tl::unexpected(found.error());
  PlacedField field{file, found->grid, version_of(file, *opened->source), std::move(opened->notes)};
  if (found->is_assumed) {
    field.notes.push_back(
        "its file places it elsewhere than the volume; its voxels are taken for those of the "
        "volume");
  }
  VolumeSource& volume = *opened->source;  // then a part of `source`
  const auto source = at_voxels(field, std::move(opened->source), grid, {});
  if (!source) return tl::unexpected(source.error());
  if (auto fits = check_memory(file, **source); !fits) return tl::unexpected(fits.error());
  if (file.is_labels) {
    auto categories = field_categories(file, volume);
    if (!categories) return tl::unexpected(categories.error());
    field.categories = std::move(*categories);
  }
  field.memory_bytes = (*source)->resident_bytes();
  auto* const resampled = dynamic_cast<ResampledSource*>(source->get());
  if (!options.measures || !resampled) return field;
  if (file.is_labels) {
    field.notes.push_back(fmt::format(
        "of {} × {} × {} voxels: each voxel of the volume has the nearest of its labels", voxels.x,
        voxels.y, voxels.z));
    return field;
  }
  auto text = resampling_note(*resampled, voxels);
  if (!text) return tl::unexpected(text.error());
  field.notes.push_back(std::move(*text));
  return field;
}

Result<std::unique_ptr<VolumeSource>> open(const PlacedField& field, const VolumeGrid& to,
                                           const ResamplingOptions& options) {
  auto opened = open_field_file(field.file);
  if (!opened) return tl::unexpected(opened.error());
  return at_voxels(field, std::move(opened->source), to, options);
}

}  // namespace

Result<std::vector<FieldFile>> field_files(std::span<const std::string> texts,
                                           const import::ImportOptions& options,
                                           const fs::path& volume) {
  auto fields = parse_all(texts, options, volume);
  if (!fields) return fields;
  for (const FieldFile& field : *fields) {
    if (!is_pattern(field.file) && !is_list(field.file)) continue;
    return fail(Status::invalid_argument,
                fmt::format("field '{}': expected one file, found {}: patterns and lists are for "
                            "the time steps of a scene",
                            field.name, field.file.string()));
  }
  return fields;
}

Result<std::vector<std::vector<FieldFile>>> field_files_of_steps(
    std::span<const std::string> texts, const import::ImportOptions& options,
    const SceneInputs& scene) {
  const size_t steps = scene.times.size();
  const auto fields = parse_all(texts, options, scene.volumes.front().file);
  if (!fields) return tl::unexpected(fields.error());
  std::vector<std::vector<FieldFile>> of_steps(steps);
  for (const FieldFile& field : *fields) {
    if (field.derived) {
      for (std::vector<FieldFile>& of_step : of_steps) of_step.push_back(field);
      continue;
    }
    const auto volumes = volumes_of_field(field, scene);
    if (!volumes) return tl::unexpected(volumes.error());
    if (volumes->size() != steps && volumes->size() != 1) {
      return fail(Status::invalid_argument,
                  fmt::format("field '{}': expected a volume for each of the {} time steps, or one "
                              "for all, found {}",
                              field.name, steps, volumes->size()));
    }
    for (size_t step = 0; step < steps; ++step) {
      const SceneInput& volume = (*volumes)[volumes->size() == 1 ? 0 : step];
      FieldFile of_step = field;
      of_step.file = volume.file;
      of_step.options = volume.options;
      of_steps[step].push_back(std::move(of_step));
    }
  }
  return of_steps;
}

Result<std::vector<PlacedField>> place_fields(std::span<const FieldFile> files,
                                              const VolumeGrid& grid, const PlaceOptions& options,
                                              const std::function<void(const std::string&)>& tell) {
  std::vector<PlacedField> fields;
  for (const FieldFile& file : files) {
    auto field = place(file, grid, options);
    if (!field) return tl::unexpected(field.error());
    for (const std::string& text : field->notes) {
      tell(fmt::format("field '{}': {}", file.name, text));
    }
    fields.push_back(std::move(*field));
  }
  return fields;
}

std::vector<FieldInput> field_inputs(std::span<const PlacedField> fields, const VolumeGrid& grid,
                                     const ResamplingOptions& options) {
  std::vector<FieldInput> inputs;
  for (const PlacedField& field : fields) {
    inputs.push_back({field.file.name, field.file.derived ? "" : source_file_name(field.file.file),
                      [field, grid, options] { return open(field, grid, options); }, field.notes,
                      field.categories});
  }
  return inputs;
}

Result<BuildReport> build_with_fields(VolumeSource& source, std::span<const FieldInput> fields,
                                      const fs::path& target, const BuildOptions& options) {
  return fields.empty() ? build_store_file(source, target, options)
                        : build_store_with_fields(source, fields, target, options);
}

}  // namespace isosplat::cli
