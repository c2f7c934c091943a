#include "native/cli/field_inputs.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>

#include "native/builder/field_place.h"
#include "native/builder/source_path.h"
#include "native/cli/input_version.h"
#include "native/cli/outputs.h"
#include "shared/core/store/field_sections.h"
#include "shared/import/slices/slice_files.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

/// Sets the derived field that a text such as "@gradient" names.
Result<void> set_derived(const std::string& text, FieldFile& field) {
  field.derived = derived_of(text.substr(1));
  if (field.derived) return {};
  return fail(
      Status::invalid_argument,
      fmt::format("field '{}': expected @gradient or @curvature, found '{}'", field.name, text));
}

Result<FieldFile> parse(const std::string& text, const import::ImportOptions& options) {
  const size_t equals = text.find('=');
  if (equals == text.npos || equals + 1 == text.size()) {
    return fail(Status::invalid_argument,
                fmt::format("--field: expected a name and a volume, such as "
                            "temperature=temperature.nrrd, found '{}'",
                            text));
  }
  FieldFile field{text.substr(0, equals), {}, {}};
  FieldInfo info;
  info.name = field.name;
  if (auto checked = check_field(info); !checked) return tl::unexpected(checked.error());
  field.options.time_step = options.time_step;
  field.options.memory_bytes = options.memory_bytes;
  field.options.allowed = options.allowed;
  std::string file = text.substr(equals + 1);
  if (file.front() == '@') {
    if (auto set = set_derived(file, field); !set) return tl::unexpected(set.error());
    return field;
  }
  std::error_code ignored;
  const size_t hash = file.rfind('#');
  if (hash != file.npos && !fs::exists(file, ignored)) {
    field.options.dataset = file.substr(hash + 1);
    file.resize(hash);
  }
  field.file = file;
  return field;
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
  std::error_code ignored;
  if (text.find('*') != text.npos && !fs::exists(field.file, ignored)) {
    std::vector<SceneInput> volumes;
    for (fs::path& file : matching_files(text)) volumes.push_back({std::move(file), field.options});
    if (volumes.empty()) {
      return fail(Status::io_error, fmt::format("field '{}': expected files such as {}, found none",
                                                field.name, text));
    }
    return volumes;
  }
  const bool is_list = field.file.extension() == ".txt";
  auto volumes = is_list ? listed_steps(field.file, field.options)
                         : volumes_of_file(field.file, field.options);
  if (!volumes) return tl::unexpected(volumes.error());
  if (volumes->layers.size() > 1) {
    return fail(
        Status::invalid_argument,
        fmt::format("field '{}': expected one scalar at each voxel, found {} channels: save "
                    "one of them to a file",
                    field.name, volumes->layers.size()));
  }
  if (is_list && volumes->times != scene.times) {
    return fail(
        Status::invalid_argument,
        fmt::format("field '{}': expected the {} times of the scene, {} to {}, found other "
                    "times in {}",
                    field.name, scene.times.size(), scene.times.front(), scene.times.back(), text));
  }
  return std::move(volumes->volumes);
}

Result<import::OpenVolume> open_file(const FieldFile& file) {
  auto opened = import::open_volume(file.file, file.options);
  if (opened && file.derived) {
    opened->source = std::make_unique<DerivedSource>(std::move(opened->source), *file.derived);
    opened->notes.clear();  // those of the volume itself
  }
  return opened;
}

Result<PlacedField> place(const FieldFile& file, const VolumeGrid& grid, const fs::path& target) {
  auto opened = open_file(file);
  if (!opened) return tl::unexpected(opened.error());
  if (auto other = check_not_input(target, opened->source->files()); !other) {
    return tl::unexpected(other.error());
  }
  const auto found = find_field_place(file.name, grid, opened->source->header().grid);
  if (!found) return tl::unexpected(found.error());
  PlacedField field{file, found->grid, std::move(opened->notes)};
  if (found->is_assumed) {
    field.notes.push_back(
        "its file places it elsewhere than the volume; its voxels are taken for those of the "
        "volume");
  }
  std::string note;
  auto resampled = field_at_voxels(std::move(opened->source), field.grid, grid,
                                   file.options.memory_bytes, &note);
  if (!resampled) return tl::unexpected(resampled.error());
  if (!note.empty()) field.notes.push_back(std::move(note));
  return field;
}

Result<std::unique_ptr<VolumeSource>> open(const FieldFile& file, const VolumeGrid& from,
                                           const VolumeGrid& to) {
  auto opened = open_file(file);
  if (!opened) return tl::unexpected(opened.error());
  return field_at_voxels(std::move(opened->source), from, to, file.options.memory_bytes);
}

}  // namespace

Result<std::vector<FieldFile>> field_files(std::span<const std::string> texts,
                                           const import::ImportOptions& options,
                                           const fs::path& volume) {
  std::vector<FieldFile> fields;
  for (const std::string& text : texts) {
    auto field = parse(text, options);
    if (!field) return tl::unexpected(field.error());
    if (field->derived) {
      if (volume.empty()) {
        return fail(Status::invalid_argument,
                    fmt::format("field '{}': expected a file, since nothing can be derived from "
                                "labels and adaptive grids, found {}",
                                field->name, text));
      }
      field->file = volume;
      field->options = options;
    }
    fields.push_back(std::move(*field));
  }
  return fields;
}

Result<std::vector<std::vector<FieldFile>>> field_files_of_steps(
    std::span<const std::string> texts, const import::ImportOptions& options,
    const SceneInputs& scene) {
  const size_t steps = scene.times.size();
  const auto fields = field_files(texts, options, scene.volumes.front().file);
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
      of_steps[step].push_back({field.name, volume.file, volume.options});
    }
  }
  return of_steps;
}

std::string field_version(const FieldFile& field) {
  std::string version = fmt::format("\n{} {} {} {} ", field.name, field.options.dataset,
                                    field.options.time_step.value_or(-1),
                                    field.derived ? static_cast<int>(*field.derived) : -1);
  const auto opened = import::open_volume(field.file, field.options);
  version += input_versions(opened ? opened->source->files() : std::vector{field.file});
  return version;
}

Result<std::vector<PlacedField>> place_fields(std::span<const FieldFile> files,
                                              const VolumeGrid& grid, const fs::path& target,
                                              const std::function<void(const std::string&)>& tell) {
  std::vector<PlacedField> fields;
  for (const FieldFile& file : files) {
    auto field = place(file, grid, target);
    if (!field) return tl::unexpected(field.error());
    for (const std::string& note : field->notes) {
      tell(fmt::format("field '{}': {}", file.name, note));
    }
    fields.push_back(std::move(*field));
  }
  return fields;
}

std::vector<FieldInput> field_inputs(std::span<const PlacedField> fields, const VolumeGrid& grid) {
  std::vector<FieldInput> inputs;
  for (const PlacedField& field : fields) {
    inputs.push_back({field.file.name, field.file.derived ? "" : source_file_name(field.file.file),
                      [field, grid] { return open(field.file, field.grid, grid); }, field.notes});
  }
  return inputs;
}

Result<BuildReport> build_with_fields(VolumeSource& source, std::span<const FieldInput> fields,
                                      const fs::path& target, const BuildOptions& options) {
  return fields.empty() ? build_store_file(source, target, options)
                        : build_store_with_fields(source, fields, target, options);
}

}  // namespace isosplat::cli
