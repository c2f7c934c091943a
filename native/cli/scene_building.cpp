#include "native/cli/scene_building.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "native/cli/building.h"
#include "native/cli/input_version.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/cli/told_notes.h"
#include "native/scene/layer_surfaces.h"
#include "native/scene/scene_output.h"
#include "shared/core/preprocess/quantization.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

std::string which(const SceneInput& input) {
  return fmt::format("{}, channel {}, step {}", input.file.string(), input.layer, input.step);
}

/// The mapping to quantized values that the steps of a layer share.
struct SharedValues {
  std::shared_ptr<const VoxelScan> scan;  ///< null: each volume has its own
  std::string key;                        ///< all of it that determines the bytes of a store
};

/// A build of a scene, one volume after the other.
class SceneBuild {
 public:
  SceneBuild(const SceneInputs& inputs, const fs::path& output, const SceneBuildOptions& options)
      : inputs_(inputs), output_path_(output), options_(options) {}

  Result<SceneReport> run();

 private:
  Result<import::OpenVolume> open(const SceneInput& input);
  Result<SharedValues> shared_values(size_t layer);
  Result<void> build(const SceneInput& input, const SharedValues& values);
  std::vector<FieldFile> field_files(const SceneInput& input) const;
  Result<std::vector<PlacedField>> fields(const SceneInput& input, const VolumeGrid& grid);
  std::string store_name(const SceneInput& input) const;
  Scene without_surfaces() const;
  std::array<float, 3> layer_colour(size_t layer) const;
  Result<Scene> scene() const;
  size_t steps() const { return inputs_.times.size(); }
  bool has_time() const { return steps() > 1; }

  const SceneInputs& inputs_;
  const fs::path& output_path_;
  const SceneBuildOptions& options_;
  std::optional<SceneOutput> output_;
  std::optional<ProgressLine> progress_;
  ToldNotes notes_;
  size_t built_ = 0;
  ClampedVoxels clamped_;
  SceneReport report_;
};

std::string SceneBuild::store_name(const SceneInput& input) const {
  std::string name = inputs_.layers.size() > 1 ? fmt::format("layer_{:04}", input.layer) : "volume";
  if (has_time()) name += fmt::format("_{:05}", input.step);
  return name;
}

/// Opens a volume, and prints those of its notes that are new.
Result<import::OpenVolume> SceneBuild::open(const SceneInput& input) {
  auto opened = import::open_volume(input.file, input.options);
  if (!opened) return opened;
  if (auto other = check_not_input(output_path_, opened->source->files()); !other) {
    return tl::unexpected(other.error());
  }
  for (const std::string& text : opened->notes) notes_.tell(text, *progress_);
  return opened;
}

/// Finds the mapping for all steps of a layer. Reads the headers of all steps, and their voxels
/// until more voxels cannot change the mapping.
Result<SharedValues> SceneBuild::shared_values(size_t layer) {
  // With a range, the mapping of each store follows from the range, and not from the voxels.
  if (!has_time() || options_.build.range) return SharedValues{};
  const double max_error = options_.build.max_error;
  std::optional<VoxelScan> all;
  std::optional<VolumeHeader> first;
  for (const SceneInput& input : inputs_.volumes) {
    if (input.layer != layer) continue;
    progress_->show(0.2 * static_cast<double>(input.step) / static_cast<double>(steps()),
                    fmt::format("reading the values of step {}", input.step));
    const auto opened = open(input);
    if (!opened) return tl::unexpected(opened.error());
    const VolumeHeader& header = opened->source->header();
    if (first && (header.type != first->type || header.slope != first->slope ||
                  header.intercept != first->intercept)) {
      progress_->clear();
      note(
          fmt::format("{} has another type or scale of values than the first step: each step is "
                      "rounded by itself",
                      which(input)));
      return SharedValues{};
    }
    if (!first) first = header;
    // More voxels cannot change the choice. The headers of the other steps still can.
    if (all && all->is_settled() && max_error == 0) continue;
    const auto values = scan_for_build(*opened->source, options_.build);
    if (!values) return tl::unexpected(values.error());
    if (all) {
      all->add(*values);
    } else {
      all = *values;
    }
  }
  const auto quantization = choose_quantization(*first, *all, max_error);
  if (!quantization) return tl::unexpected(quantization.error());
  const ValueMapping& mapping = quantization->mapping();
  SharedValues values;
  values.key = fmt::format("{} {} {} {} {}", mapping.offset, mapping.scale, mapping.max_error,
                           mapping.bits, mapping.has_missing);
  if (!all->is_settled() || max_error > 0) {
    values.key += fmt::format(" {} {}", all->min(), all->max());
  }
  values.scan = std::make_shared<const VoxelScan>(std::move(*all));
  return values;
}

std::vector<FieldFile> SceneBuild::field_files(const SceneInput& input) const {
  if (options_.fields.empty()) return {};
  std::vector<FieldFile> files = options_.fields[input.step];
  for (FieldFile& field : files) {
    if (!field.derived) continue;
    field.file = input.file;
    field.options = input.options;
  }
  return files;
}

Result<std::vector<PlacedField>> SceneBuild::fields(const SceneInput& input,
                                                    const VolumeGrid& grid) {
  return place_fields(field_files(input), grid, {output_path_, input.step == 0},
                      [&](const std::string& text) { notes_.tell(text, *progress_); });
}

Result<void> SceneBuild::build(const SceneInput& input, const SharedValues& values) {
  const std::string name = store_name(input);
  const size_t count = inputs_.volumes.size();
  const auto show = [&](double of_this, std::string_view detail) {
    const double done = (static_cast<double>(built_) + of_this) / static_cast<double>(count);
    progress_->show(0.2 + 0.8 * done, fmt::format("store {} of {}{}", built_ + 1, count, detail));
  };
  show(0, "");
  auto opened = open(input);
  if (!opened) return tl::unexpected(opened.error());
  std::string key = options_.key + input_versions(opened->source->files());
  key += fmt::format("\n{} {}\n{}", input.layer, input.step, values.key);
  const VolumeGrid grid = opened->source->header().grid;
  const auto fields = this->fields(input, grid);
  if (!fields) return tl::unexpected(fields.error());
  for (const PlacedField& field : *fields) key += field.version;
  if (output_->has(name, key)) {
    ++report_.kept;
  } else {
    BuildOptions build = options_.build;
    build.scan = values.scan;
    build.notes = opened->notes;
    build.source_file = input.file.filename().string();
    build.progress = [&](const BuildProgress& progress) { show(progress.fraction, ""); };
    ClampedVoxels clamped;
    build.clamped = &clamped;
    const auto inputs = field_inputs(*fields, grid);
    const auto built = build_with_fields(*opened->source, inputs, output_->store_file(name), build);
    if (!built) return tl::unexpected(built.error());
    clamped_.below += clamped.below;
    clamped_.above += clamped.above;
    if (auto kept = output_->completed(name, key); !kept) return kept;
  }
  ++built_;
  return {};
}

Scene SceneBuild::without_surfaces() const {
  Scene scene;
  scene.name = options_.name;
  if (has_time()) {
    const std::string& unit = options_.time_unit;
    scene.time = SceneTime{inputs_.times, unit.empty() ? inputs_.time_unit : unit};
  }
  for (const std::string& name : inputs_.layers) scene.layers.emplace_back().name = name;
  for (const SceneInput& input : inputs_.volumes) {
    scene.layers[input.layer].stores.push_back(SceneOutput::store_path(store_name(input)));
  }
  return scene;
}

/// The colour that the file states, or one of the palette.
std::array<float, 3> SceneBuild::layer_colour(size_t layer) const {
  if (layer < inputs_.colours.size() && inputs_.colours[layer]) return *inputs_.colours[layer];
  const Vec3f colour = kSurfaceColours[layer % kSurfaceColours.size()];
  return {colour.x, colour.y, colour.z};
}

/// The scene of the stores. The surface of a layer is at the first suggestion of its middle step.
Result<Scene> SceneBuild::scene() const {
  Scene scene = without_surfaces();
  for (const SceneInput& input : inputs_.volumes) {
    if (input.step != steps() / 2) continue;
    SceneLayer& layer = scene.layers[input.layer];
    const auto opened = StoreFile::open(output_->store_file(store_name(input)));
    if (!opened) return tl::unexpected(opened.error());
    if (const auto isovalue = suggested_isovalue((*opened)->info())) {
      SceneSurface& surface = layer.surfaces.emplace_back();
      surface.isovalue = *isovalue;
      if (inputs_.layers.size() > 1) surface.colour = layer_colour(input.layer);
    }
  }
  return scene;
}

Result<SceneReport> SceneBuild::run() {
  const auto begin = std::chrono::steady_clock::now();
  if (auto valid = SceneOutput::check(without_surfaces()); !valid) {
    return tl::unexpected(valid.error());
  }
  auto output = SceneOutput::create(output_path_, options_.force);
  if (!output) return tl::unexpected(output.error());
  output_ = std::move(*output);
  progress_.emplace(fmt::format("Building {}", output_path_.string()));
  for (size_t layer = 0; layer < inputs_.layers.size(); ++layer) {
    const auto values = shared_values(layer);
    if (!values) return tl::unexpected(values.error());
    for (const SceneInput& input : inputs_.volumes) {
      if (input.layer != layer) continue;
      if (auto built = build(input, *values); !built) return tl::unexpected(built.error());
    }
  }
  const auto made = scene();
  if (!made) return tl::unexpected(made.error());
  const auto bytes = output_->finish(*made);
  if (!bytes) return tl::unexpected(bytes.error());
  progress_->clear();
  note_clamped(clamped_);
  report_.layers = inputs_.layers.size();
  report_.steps = steps();
  report_.bytes = *bytes;
  report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report_;
}

}  // namespace

Result<SceneReport> build_scene(const SceneInputs& inputs, const fs::path& output,
                                const SceneBuildOptions& options) {
  return SceneBuild(inputs, output, options).run();
}

}  // namespace isosplat::cli
