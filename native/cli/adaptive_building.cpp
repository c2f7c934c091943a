#include "native/cli/adaptive_building.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <vector>

#include "native/cli/adaptive_fields.h"
#include "native/cli/building.h"
#include "native/cli/input_version.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/cli/told_notes.h"
#include "native/scene/layer_surfaces.h"
#include "native/scene/scene_output.h"
#include "shared/core/adaptive/drawn_cells.h"
#include "shared/core/adaptive/level_source.h"
#include "shared/core/unstructured/resample.h"
#include "shared/import/vtk_amr/vtk_amr.h"
#include "shared/import/vtk_mesh/vtk_mesh.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

class AdaptiveBuild {
 public:
  AdaptiveBuild(const fs::path& volume, const fs::path& output, const AdaptiveBuildOptions& options)
      : volume_(volume), output_path_(output), options_(options), build_(options.scene.build) {}

  Result<SceneReport> run();

 private:
  Result<import::OpenAdaptiveGrid> open();
  Result<import::OpenAdaptiveGrid> open_mesh();
  uint64_t grid_memory() const;
  Result<void> scan();
  Result<void> build(size_t number);
  Scene scene(std::optional<double> isovalue) const;
  Result<std::optional<double>> isovalue() const;
  static std::string store_name(size_t number) { return fmt::format("level_{}", number); }

  const fs::path& volume_;
  const fs::path& output_path_;
  const AdaptiveBuildOptions& options_;
  BuildOptions build_;
  std::string key_;  ///< all that determines the bytes of the stores
  std::vector<LevelSource> levels_;
  std::vector<AdaptiveField> fields_;
  /// Of each level: the limit of a store's size follows from its voxels, but most may be missing.
  std::vector<double> fetch_weights_;
  std::optional<SceneOutput> output_;
  std::optional<ProgressLine> progress_;
  ToldNotes notes_;
  ClampedVoxels clamped_;
  SceneReport report_;
};

/// The text about the grid of a mesh, for the user and for the stores.
std::string resampled_text(const UnstructuredMesh& mesh, const ResampledMesh& resampled) {
  const ResampleError error = measure_error(mesh, resampled);
  uint64_t leaves = 0;
  for (uint32_t level = 0; level < resampled.grid.levels(); ++level) {
    for (const auto& [key, brick] : resampled.grid.bricks(level)) {
      leaves += static_cast<uint64_t>(
          std::count(brick.states.begin(), brick.states.end(), CellState::leaf));
    }
  }
  std::string text = fmt::format(
      "{} cells of a mesh became {} cells of an adaptive grid. At {} random points, its values "
      "differ from those of the mesh by at most {:.3g}, RMS {:.3g} (limit: {:.3g})",
      with_commas(mesh.cells()), with_commas(leaves), with_commas(error.points), error.max,
      error.rms, resampled.max_error);
  if (error.above > 0) {
    text += fmt::format(", by more than the limit at {:.2g} % of them", 100 * error.above);
  }
  if (error.outside > 0) {
    text += fmt::format("; {:.2g} % of the mesh, at its border and at gaps, have no values",
                        100 * error.outside);
  }
  return text;
}

/// Brings an unstructured grid to an adaptive one. --max-error is the limit of the difference
/// between them; the stores' own error is the smallest that 16 bits allow.
Result<import::OpenAdaptiveGrid> AdaptiveBuild::open_mesh() {
  const uint64_t memory = grid_memory();
  auto opened = import::open_vtk_mesh(volume_, options_.import, memory);
  if (!opened) return tl::unexpected(opened.error());
  progress_->show(0, "resampling the mesh");
  const UnstructuredMesh& mesh = opened->mesh;
  auto resampled =
      resample(mesh, {build_.max_error, memory - std::min(memory, mesh.memory_bytes())});
  if (!resampled) {
    return fail(resampled.error().status,
                fmt::format("{}: {}", volume_.string(), resampled.error().message));
  }
  build_.max_error = 0;
  opened->notes.push_back(resampled_text(mesh, *resampled));
  VolumeHeader header;
  header.format = opened->format;
  header.name = opened->name;
  header.grid = resampled->level_0;
  return import::OpenAdaptiveGrid{std::move(resampled->grid), std::move(header),
                                  std::move(opened->notes), std::move(opened->files)};
}

/// Half of the memory is for the grid and those of the fields.
uint64_t AdaptiveBuild::grid_memory() const {
  return build_.memory_bytes / 2 / (1 + options_.fields.size());
}

Result<import::OpenAdaptiveGrid> AdaptiveBuild::open() {
  auto opened = options_.kind == GridKind::unstructured
                    ? open_mesh()
                    : import::open_vtk_amr(volume_, options_.import, grid_memory());
  if (!opened) return opened;
  if (auto other = check_not_input(output_path_, opened->files); !other) {
    return tl::unexpected(other.error());
  }
  for (const std::string& text : opened->notes) notes_.tell(text, *progress_);
  const size_t fields = options_.fields.size();
  auto opened_fields = open_adaptive_fields(
      options_.fields, options_.kind, opened->grid, opened->header, output_path_,
      grid_memory() * fields, [&](const std::string& text) { notes_.tell(text, *progress_); });
  if (!opened_fields) return tl::unexpected(opened_fields.error());
  fields_ = std::move(opened_fields->fields);
  if (auto drawn = choose_drawn_cells(opened->grid); !drawn) return tl::unexpected(drawn.error());
  build_.notes = opened->notes;
  key_ = options_.scene.key + input_versions(opened->files) + opened_fields->version;
  return opened;
}

/// Finds the mapping to quantized values for all levels.
Result<void> AdaptiveBuild::scan() {
  if (build_.range) return {};  // then the mapping follows from the range
  std::shared_ptr<VoxelScan> all;
  for (LevelSource& level : levels_) {
    progress_->show(0.1, "reading the values");
    auto values = scan_for_build(level, build_);
    if (!values) return tl::unexpected(values.error());
    const Index3 n = level.header().grid.voxels;
    const double voxels = 1.0 * n.x * n.y * n.z;
    const double present = 1 - static_cast<double>(values->missing()) / voxels;
    fetch_weights_.push_back(build_.fetch_weight * present * present);
    if (all) {
      all->add(*values);
    } else {
      all = std::make_shared<VoxelScan>(std::move(*values));
    }
  }
  build_.scan = std::move(all);
  return {};
}

Result<void> AdaptiveBuild::build(size_t number) {
  const std::string name = store_name(number);
  if (output_->has(name, key_)) {
    ++report_.kept;
    return {};
  }
  const auto count = static_cast<double>(levels_.size());
  build_.title = fmt::format("{}, level {}", options_.scene.name, levels_[number].level());
  build_.source_file = volume_.filename().string();
  build_.progress = [&](const BuildProgress& progress) {
    progress_->show(0.2 + 0.8 * (static_cast<double>(number) + progress.fraction) / count,
                    fmt::format("level {} of {}", number + 1, levels_.size()));
  };
  ClampedVoxels clamped;
  build_.clamped = &clamped;
  if (!fetch_weights_.empty()) build_.fetch_weight = fetch_weights_[number];
  std::vector<FieldInput> fields;
  for (const AdaptiveField& field : fields_) {
    fields.push_back(field.input(levels_[number].level(), levels_[number].header().grid));
  }
  const auto built = build_with_fields(levels_[number], fields, output_->store_file(name), build_);
  if (!built) return tl::unexpected(built.error());
  clamped_.below += clamped.below;
  clamped_.above += clamped.above;
  return output_->completed(name, key_);
}

/// The scene of all levels, with a surface if there is an isovalue.
Scene AdaptiveBuild::scene(std::optional<double> isovalue) const {
  Scene scene;
  scene.name = options_.scene.name;
  for (size_t i = 0; i < levels_.size(); ++i) {
    SceneLayer& layer = scene.layers.emplace_back();
    layer.name = fmt::format("level {}", levels_[i].level());
    layer.part_of = scene.name.empty() ? "adaptive grid" : scene.name;
    layer.stores.push_back(SceneOutput::store_path(store_name(i)));
    if (!isovalue) continue;
    const Vec3f colour = kSurfaceColours.front();
    layer.surfaces.push_back({*isovalue, {{colour.x, colour.y, colour.z}}, 1});
  }
  return scene;
}

/// The first suggestion for the finest level, where the simulation has its detail.
Result<std::optional<double>> AdaptiveBuild::isovalue() const {
  const auto finest = StoreFile::open(output_->store_file(store_name(levels_.size() - 1)));
  if (!finest) return tl::unexpected(finest.error());
  return suggested_isovalue((*finest)->info());
}

Result<SceneReport> AdaptiveBuild::run() {
  const auto begin = std::chrono::steady_clock::now();
  if (options_.import.time_step.value_or(0) != 0) {
    return fail(
        Status::invalid_argument,
        fmt::format("{}: {} has no time steps: remove --time-step", volume_.string(),
                    options_.kind == GridKind::unstructured ? "a mesh" : "an adaptive grid"));
  }
  progress_.emplace(fmt::format("Building {}", output_path_.string()));
  progress_->show(0, "reading the grid");
  const auto opened = open();
  if (!opened) return tl::unexpected(opened.error());
  for (uint32_t level = 0; level < opened->grid.levels(); ++level) {
    if (auto source = LevelSource::create(opened->grid, level, opened->header)) {
      levels_.push_back(std::move(*source));
    }
  }
  if (levels_.empty()) {
    return fail(Status::malformed_volume,
                volume_.string() + ": expected cells with values, found none");
  }
  // Fails before stores are built, as far as possible.
  if (auto valid = SceneOutput::check(scene(std::nullopt)); !valid) {
    return tl::unexpected(valid.error());
  }
  auto output = SceneOutput::create(output_path_, options_.scene.force);
  if (!output) return tl::unexpected(output.error());
  output_ = std::move(*output);
  if (auto scanned = scan(); !scanned) return tl::unexpected(scanned.error());
  for (size_t i = 0; i < levels_.size(); ++i) {
    if (auto built = build(i); !built) return tl::unexpected(built.error());
  }
  const auto suggested = isovalue();
  if (!suggested) return tl::unexpected(suggested.error());
  const auto bytes = output_->finish(scene(*suggested));
  if (!bytes) return tl::unexpected(bytes.error());
  progress_->clear();
  note_clamped(clamped_);
  report_.layers = levels_.size();
  report_.steps = 1;
  report_.bytes = *bytes;
  report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report_;
}

}  // namespace

Result<SceneReport> build_adaptive(const fs::path& volume, const fs::path& output,
                                   const AdaptiveBuildOptions& options) {
  return AdaptiveBuild(volume, output, options).run();
}

}  // namespace isosplat::cli
