#include "native/cli/label_building.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <mutex>
#include <numeric>
#include <thread>

#include "native/builder/parallel.h"
#include "native/builder/refusals.h"
#include "native/cli/input_version.h"
#include "native/cli/label_inputs.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/cli/told_notes.h"
#include "native/labels/label_colours.h"
#include "native/scene/scene_output.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

/// The fraction of the progress that the scan of the labels takes.
constexpr double kScanPart = 0.1;

/// The largest number of translucent surfaces in a picture (docs/ARCHITECTURE.md).
constexpr std::ptrdiff_t kMaxTranslucent = 8;

uint64_t box_voxels(const FoundLabel& label) {
  return static_cast<uint64_t>(label.high.x - label.low.x + 1) *
         static_cast<uint64_t>(label.high.y - label.low.y + 1) *
         static_cast<uint64_t>(label.high.z - label.low.z + 1);
}

/// A volume of labels. Its voxels are dropped after its stores are built, and this remains.
struct LabelGroup {
  size_t number = 0;  ///< from 0
  LabelTable table;
  VolumeHeader header;
  std::string key;  ///< all that determines the bytes of its stores, except for the labels' names
  std::vector<FoundLabel> labels;
  std::vector<PlacedField> fields;

  std::string store_name(const FoundLabel& label) const {
    return number == 0 ? fmt::format("label_{}", label.value)
                       : fmt::format("layer_{}_label_{}", number, label.value);
  }

  std::string name_of(const FoundLabel& label) const {
    const auto found = table.find(label.value);
    if (found != table.end() && !found->second.name.empty()) return found->second.name;
    return fmt::format("label {}", label.value);
  }
};

/// A label of a scene.
struct SceneEntry {
  const LabelGroup* group;
  const FoundLabel* label;
};

class LabelBuild {
 public:
  LabelBuild(const fs::path& volume, const fs::path& output, const LabelBuildOptions& options)
      : volume_(volume), output_path_(output), options_(options), build_(options.scene.build) {}

  Result<SceneReport> run();

 private:
  Result<import::OpenVolume> open(const LabelInput& input, LabelGroup& group);
  Result<LabelRows> scan(const LabelInput& input, VolumeSource& source, LabelGroup& group);
  Result<void> build_group(const LabelInput& input);
  Result<void> build_all(const LabelGroup& group, const LabelRows& rows);
  Result<void> build(const LabelGroup& group, const FoundLabel& label, const LabelRows& rows,
                     uint64_t memory_bytes);
  unsigned parallel_builds(const LabelGroup& group, uint64_t memory_bytes) const;
  Scene scene() const;
  void show(double of_group, std::string_view detail);

  const fs::path& volume_;
  const fs::path& output_path_;
  const LabelBuildOptions& options_;
  BuildOptions build_;
  size_t inputs_ = 1;              ///< their number
  std::deque<LabelGroup> groups_;  ///< those that were scanned
  std::optional<SceneOutput> output_;
  std::optional<ProgressLine> progress_;
  ToldNotes notes_;
  std::mutex mutex_;  ///< of the output, the progress and the report, while labels are built
  size_t built_ = 0;
  uint64_t built_voxels_ = 0, all_voxels_ = 0;  ///< of the group
  SceneReport report_;
};

void LabelBuild::show(double of_group, std::string_view detail) {
  const double done = static_cast<double>(groups_.size() - 1) + of_group;
  progress_->show(done / static_cast<double>(inputs_), detail);
}

Result<import::OpenVolume> LabelBuild::open(const LabelInput& input, LabelGroup& group) {
  auto opened = input.open();
  if (!opened) return opened;
  if (auto other = check_not_input(output_path_, opened->source->files()); !other) {
    return tl::unexpected(other.error());
  }
  build_.notes = opened->notes;
  for (const std::string& text : opened->notes) notes_.tell(text, *progress_);
  group.header = opened->source->header();
  group.table = input.table;
  group.key = options_.scene.key +
              (options_.surface == LabelSurface::raw ? "\nraw" : "\nsmooth distances 3");
  group.key += input_versions(opened->source->files());
  auto placed = place_fields(options_.fields, group.header.grid, {.target = output_path_},
                             [&](const std::string& text) { notes_.tell(text, *progress_); });
  if (!placed) return tl::unexpected(placed.error());
  for (const PlacedField& field : *placed) group.key += field.version;
  group.fields = std::move(*placed);
  return opened;
}

Result<LabelRows> LabelBuild::scan(const LabelInput& input, VolumeSource& source,
                                   LabelGroup& group) {
  auto rows = LabelRows::create(
      group.header.grid.voxels, build_.memory_bytes / 2,
      build_.temporary_folder.empty() ? fs::temp_directory_path() : build_.temporary_folder);
  if (!rows) return rows;
  LabelScanOptions scan;
  scan.background = input.background;
  scan.only = input.only;
  scan.max_labels = kMaxLayers;
  for (const LabelGroup& other : groups_) scan.max_labels -= other.labels.size();
  scan.progress = [&](double done) { show(kScanPart * done, "reading the labels"); };
  auto labels = scan_labels(source, *rows, scan);
  if (!labels) return tl::unexpected(labels.error());
  group.labels = std::move(*labels);
  return rows;
}

/// Builds of small stores use one thread each. The memory of the largest decides how many run at a
/// time.
unsigned LabelBuild::parallel_builds(const LabelGroup& group, uint64_t memory_bytes) const {
  const unsigned threads =
      build_.threads > 0 ? build_.threads : std::max(1u, std::thread::hardware_concurrency());
  BuildOptions one = build_;
  one.threads = 1;
  uint64_t most = 1;
  for (const FoundLabel& label : group.labels) {
    const LabelSource source({}, group.header, label, options_.surface, "");
    most = std::max(most, min_memory(source, one));
  }
  uint64_t of_field = 0;
  for (const PlacedField& field : group.fields) {
    of_field = std::max(of_field, field.memory_bytes);
  }
  return static_cast<unsigned>(std::clamp<uint64_t>(memory_bytes / (most + of_field), 1, threads));
}

Result<void> LabelBuild::build(const LabelGroup& group, const FoundLabel& label,
                               const LabelRows& rows, uint64_t memory_bytes) {
  const std::string title = group.name_of(label), name = group.store_name(label);
  const std::string key = group.key + '\n' + title;
  {
    const std::lock_guard lock(mutex_);
    if (output_->has(name, key)) {
      ++report_.kept;
      ++built_;
      built_voxels_ += box_voxels(label);
      return {};
    }
  }
  LabelSource source(rows.volume(), group.header, label, options_.surface, title);
  BuildOptions build = build_;
  build.title = title;
  build.source_file = volume_.filename().string();
  build.scan = LabelSource::all_values();
  build.max_error = 0;
  build.only_isovalue = kLabelFieldIsovalue;
  static const DistanceLevels kDistances(kLabelFieldDistances);
  if (options_.surface == LabelSurface::smooth) build.coarse_levels = &kDistances;
  build.threads = 1;
  build.memory_bytes = memory_bytes;
  // The surface of a label on the border of the volume lies half a voxel outside, in cells whose
  // outer voxels are one outside.
  constexpr ResamplingOptions kOneOutside{.voxels = 0.5, .grid_voxels = 0.5};
  std::vector<PlacedField> placed = group.fields;
  for (PlacedField& field : placed) field.file.options.memory_bytes = memory_bytes;
  const auto fields = field_inputs(placed, source.header().grid, kOneOutside);
  const auto stored = build_with_fields(source, fields, output_->store_file(name), build);
  if (!stored) return tl::unexpected(stored.error());
  const std::lock_guard lock(mutex_);
  if (auto kept = output_->completed(name, key); !kept) return kept;
  built_voxels_ += box_voxels(label);
  const double done = static_cast<double>(built_voxels_) / static_cast<double>(all_voxels_);
  show(kScanPart + (1 - kScanPart) * done,
       fmt::format("label {} of {}", ++built_, group.labels.size()));
  return {};
}

Result<void> LabelBuild::build_all(const LabelGroup& group, const LabelRows& rows) {
  const std::vector<FoundLabel>& labels = group.labels;
  std::vector<size_t> order(labels.size());
  std::iota(order.begin(), order.end(), size_t{0});
  // The largest first, so that no thread begins it when the others have nothing left to do.
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return std::pair(box_voxels(labels[b]), a) < std::pair(box_voxels(labels[a]), b);
  });
  built_ = 0;
  built_voxels_ = all_voxels_ = 0;
  for (const FoundLabel& label : labels) all_voxels_ += box_voxels(label);
  const uint64_t memory_bytes = build_.memory_bytes - rows.memory_bytes();
  const unsigned builds = parallel_builds(group, memory_bytes);
  return with_refusals([&]() -> Result<void> {
    Result<void> result;
    parallel_for(builds, order.size(), [&](unsigned, size_t i) {
      {
        const std::lock_guard lock(mutex_);
        if (!result) return;
      }
      auto built = build(group, labels[order[i]], rows, memory_bytes / builds);
      const std::lock_guard lock(mutex_);
      if (result && !built) result = std::move(built);
    });
    return result;
  });
}

/// The scene of all labels that were scanned, by value.
Scene LabelBuild::scene() const {
  Scene scene;
  scene.name = options_.scene.name;
  std::vector<SceneEntry> entries;
  for (const LabelGroup& group : groups_) {
    for (const FoundLabel& label : group.labels) entries.push_back({&group, &label});
  }
  std::stable_sort(entries.begin(), entries.end(), [](const SceneEntry& a, const SceneEntry& b) {
    return a.label->value < b.label->value;
  });
  for (const auto& [group, found] : entries) {
    SceneLayer& layer = scene.layers.emplace_back();
    layer.name = group->name_of(*found);
    layer.stores.push_back(SceneOutput::store_path(group->store_name(*found)));
    const double voxel_volume = std::abs(determinant(group->header.grid.cell_edges()));
    layer.label =
        SceneLabel{found->value, found->voxels, voxel_volume * static_cast<double>(found->voxels)};
    SceneSurface& surface = layer.surfaces.emplace_back();
    surface.isovalue = kLabelFieldIsovalue;
    surface.colour = label_colour(found->value);
    const auto entry = group->table.find(found->value);
    if (entry == group->table.end()) continue;
    if (entry->second.colour) surface.colour = entry->second.colour;
    layer.visible = entry->second.visible;
    surface.opacity = entry->second.opacity;
  }
  return scene;
}

/// Makes all surfaces opaque if more are translucent than a picture can have.
void limit_translucent(Scene& scene) {
  const auto translucent = std::count_if(
      scene.layers.begin(), scene.layers.end(),
      [](const SceneLayer& layer) { return layer.visible && layer.surfaces.front().opacity < 1; });
  if (translucent <= kMaxTranslucent) return;
  for (SceneLayer& layer : scene.layers) layer.surfaces.front().opacity = 1;
  note(
      fmt::format("the table makes {} labels translucent: a picture can have {}, so all are opaque",
                  translucent, kMaxTranslucent));
}

/// Builds the stores of a volume of labels. Keeps its voxels in memory only during this call.
Result<void> LabelBuild::build_group(const LabelInput& input) {
  LabelGroup& group = groups_.emplace_back();
  group.number = groups_.size() - 1;
  auto opened = open(input, group);
  if (!opened) return tl::unexpected(opened.error());
  const auto rows = scan(input, *opened->source, group);
  if (!rows) return tl::unexpected(rows.error());
  opened->source.reset();
  if (group.labels.empty()) return {};
  // Fails before stores are built, as far as possible.
  if (auto valid = SceneOutput::check(scene()); !valid) return valid;
  if (!output_) {
    auto output = SceneOutput::create(output_path_, options_.scene.force);
    if (!output) return tl::unexpected(output.error());
    output_ = std::move(*output);
  }
  return build_all(group, *rows);
}

Result<SceneReport> LabelBuild::run() {
  const auto begin = std::chrono::steady_clock::now();
  const auto inputs = label_inputs(volume_, options_.import, options_.table);
  if (!inputs) return tl::unexpected(inputs.error());
  inputs_ = inputs->size();
  progress_.emplace(fmt::format("Building {}", output_path_.string()));
  for (const LabelInput& input : *inputs) {
    if (auto built = build_group(input); !built) return tl::unexpected(built.error());
  }
  progress_->clear();
  Scene made = scene();
  if (made.layers.empty()) {
    return fail(Status::malformed_volume,
                fmt::format("{}: expected labels, found only the background ({})", volume_.string(),
                            inputs->front().background.value_or(0)));
  }
  limit_translucent(made);
  const auto bytes = output_->finish(made);
  if (!bytes) return tl::unexpected(bytes.error());
  report_.layers = made.layers.size();
  report_.steps = 1;
  report_.bytes = *bytes;
  report_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report_;
}

}  // namespace

Result<SceneReport> build_labels(const fs::path& volume, const fs::path& output,
                                 const LabelBuildOptions& options) {
  return LabelBuild(volume, output, options).run();
}

}  // namespace isosplat::cli
