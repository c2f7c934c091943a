#include "native/cli/label_building.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>
#include <numeric>
#include <thread>

#include "native/builder/parallel.h"
#include "native/builder/refusals.h"
#include "native/cli/input_version.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/labels/label_colours.h"
#include "native/scene/scene_output.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

/// Part of the progress until all labels are known.
constexpr double kScanPart = 0.1;

/// The largest number of translucent surfaces in a picture (docs/ARCHITECTURE.md).
constexpr size_t kMaxTranslucent = 8;

uint64_t box_voxels(const FoundLabel& label) {
  return static_cast<uint64_t>(label.high.x - label.low.x + 1) *
         static_cast<uint64_t>(label.high.y - label.low.y + 1) *
         static_cast<uint64_t>(label.high.z - label.low.z + 1);
}

std::string store_name(const FoundLabel& label) {
  return fmt::format("label_{}", label.value);
}

class LabelBuild {
 public:
  LabelBuild(const fs::path& volume, const fs::path& output, const LabelBuildOptions& options)
      : volume_(volume),
        output_path_(output),
        options_(options),
        build_(options.scene.build),
        table_(options.table) {}

  Result<SceneReport> run();

 private:
  Result<import::OpenVolume> open();
  Result<LabelRows> scan(VolumeSource& source);
  Result<void> build_all(const LabelRows& rows);
  Result<void> build(const FoundLabel& label, const LabelRows& rows, uint64_t memory_bytes);
  unsigned parallel_builds(uint64_t memory_bytes) const;
  std::string name_of(const FoundLabel& label) const;
  Scene scene();

  const fs::path& volume_;
  const fs::path& output_path_;
  const LabelBuildOptions& options_;
  BuildOptions build_;
  LabelTable table_;
  VolumeHeader header_;
  std::vector<FoundLabel> labels_;
  std::string key_;
  std::optional<SceneOutput> output_;
  std::optional<ProgressLine> progress_;
  std::mutex mutex_;  ///< of the output, the progress and the report, while labels are built
  size_t built_ = 0;
  uint64_t built_voxels_ = 0, all_voxels_ = 0;
  SceneReport report_;
};

Result<import::OpenVolume> LabelBuild::open() {
  import::ImportOptions options = options_.import;
  // Labels are not measured values: none of them means "no value".
  options.finds_missing_values = false;
  auto opened = import::open_volume(volume_, options);
  if (!opened) return opened;
  if (auto other = check_not_input(output_path_, opened->source->files()); !other) {
    return tl::unexpected(other.error());
  }
  build_.notes = opened->notes;
  for (const std::string& text : opened->notes) note(text);
  key_ = options_.scene.key + (options_.surface == LabelSurface::raw ? "\nraw" : "\nsmooth");
  key_ += input_versions(opened->source->files());
  return opened;
}

Result<LabelRows> LabelBuild::scan(VolumeSource& source) {
  auto rows = LabelRows::create(
      header_.grid.voxels, build_.memory_bytes / 2,
      build_.temporary_folder.empty() ? fs::temp_directory_path() : build_.temporary_folder);
  if (!rows) return rows;
  LabelScanOptions scan;
  scan.max_labels = kMaxLayers;
  if (is_zero_a_label(table_)) scan.background.reset();
  scan.progress = [&](double done) { progress_->show(kScanPart * done, "reading the labels"); };
  auto labels = scan_labels(source, *rows, scan);
  if (!labels) return tl::unexpected(labels.error());
  labels_ = std::move(*labels);
  return rows;
}

/// Builds of small stores use one thread each. The memory of the largest decides how many run at a
/// time.
unsigned LabelBuild::parallel_builds(uint64_t memory_bytes) const {
  const unsigned threads =
      build_.threads > 0 ? build_.threads : std::max(1u, std::thread::hardware_concurrency());
  BuildOptions one = build_;
  one.threads = 1;
  uint64_t most = 1;
  for (const FoundLabel& label : labels_) {
    const LabelSource source({}, header_.grid, label, LabelSurface::raw, "");
    most = std::max(most, min_memory(source, one));
  }
  return static_cast<unsigned>(std::clamp<uint64_t>(memory_bytes / most, 1, threads));
}

std::string LabelBuild::name_of(const FoundLabel& label) const {
  const auto found = table_.find(label.value);
  if (found != table_.end() && !found->second.name.empty()) return found->second.name;
  return fmt::format("label {}", label.value);
}

Result<void> LabelBuild::build(const FoundLabel& label, const LabelRows& rows,
                               uint64_t memory_bytes) {
  const std::string name = store_name(label), key = key_ + '\n' + name_of(label);
  {
    const std::lock_guard lock(mutex_);
    if (output_->has(name, key)) {
      ++report_.kept;
      ++built_;
      built_voxels_ += box_voxels(label);
      return {};
    }
  }
  LabelSource source(rows.volume(), header_.grid, label, options_.surface, name_of(label));
  BuildOptions build = build_;
  build.title = name_of(label);
  build.source_file = volume_.filename().string();
  build.scan = LabelSource::all_values();
  build.max_error = 0;
  build.only_isovalue = kLabelFieldIsovalue;
  build.threads = 1;
  build.memory_bytes = memory_bytes;
  const auto stored = build_store_file(source, output_->store_file(name), build);
  if (!stored) return tl::unexpected(stored.error());
  const std::lock_guard lock(mutex_);
  if (auto kept = output_->completed(name, key); !kept) return kept;
  built_voxels_ += box_voxels(label);
  const double done = static_cast<double>(built_voxels_) / static_cast<double>(all_voxels_);
  progress_->show(kScanPart + (1 - kScanPart) * done,
                  fmt::format("label {} of {}", ++built_, labels_.size()));
  return {};
}

Result<void> LabelBuild::build_all(const LabelRows& rows) {
  std::vector<size_t> order(labels_.size());
  std::iota(order.begin(), order.end(), size_t{0});
  // The largest first, so that no thread begins it when the others have nothing left to do.
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return std::pair(box_voxels(labels_[b]), a) < std::pair(box_voxels(labels_[a]), b);
  });
  for (const FoundLabel& label : labels_) all_voxels_ += box_voxels(label);
  const uint64_t memory_bytes = build_.memory_bytes - rows.memory_bytes();
  const unsigned builds = parallel_builds(memory_bytes);
  return with_refusals([&]() -> Result<void> {
    Result<void> result;
    parallel_for(builds, order.size(), [&](unsigned, size_t i) {
      {
        const std::lock_guard lock(mutex_);
        if (!result) return;
      }
      auto built = build(labels_[order[i]], rows, memory_bytes / builds);
      const std::lock_guard lock(mutex_);
      if (result && !built) result = std::move(built);
    });
    return result;
  });
}

Scene LabelBuild::scene() {
  Scene scene;
  scene.name = options_.scene.name;
  const double voxel_volume = std::abs(determinant(header_.grid.cell_edges()));
  size_t translucent = 0;
  for (const FoundLabel& found : labels_) {
    SceneLayer& layer = scene.layers.emplace_back();
    layer.name = name_of(found);
    layer.stores.push_back(SceneOutput::store_path(store_name(found)));
    layer.label =
        SceneLabel{found.value, found.voxels, voxel_volume * static_cast<double>(found.voxels)};
    SceneSurface& surface = layer.surfaces.emplace_back();
    surface.isovalue = kLabelFieldIsovalue;
    surface.colour = label_colour(found.value);
    const auto entry = table_.find(found.value);
    if (entry == table_.end()) continue;
    if (entry->second.colour) surface.colour = entry->second.colour;
    layer.visible = entry->second.visible;
    surface.opacity = entry->second.opacity;
    if (layer.visible && surface.opacity < 1) ++translucent;
  }
  if (translucent > kMaxTranslucent) {
    for (SceneLayer& layer : scene.layers) layer.surfaces.front().opacity = 1;
    note(
        fmt::format("the table makes {} labels translucent: a picture can have {}, so all are "
                    "opaque",
                    translucent, kMaxTranslucent));
  }
  return scene;
}

Result<SceneReport> LabelBuild::run() {
  const auto begin = std::chrono::steady_clock::now();
  auto opened = open();
  if (!opened) return tl::unexpected(opened.error());
  header_ = opened->source->header();
  if (table_.empty()) table_ = table_in_volume(volume_, options_.import.channel.value_or(0));
  progress_.emplace(fmt::format("Building {}", output_path_.string()));
  const auto rows = scan(*opened->source);
  if (!rows) return tl::unexpected(rows.error());
  opened->source.reset();
  progress_->clear();
  const Scene made = scene();
  if (auto valid = SceneOutput::check(made); !valid) return tl::unexpected(valid.error());
  auto output = SceneOutput::create(output_path_, options_.scene.force);
  if (!output) return tl::unexpected(output.error());
  output_ = std::move(*output);
  if (auto built = build_all(*rows); !built) return tl::unexpected(built.error());
  const auto bytes = output_->finish(made);
  if (!bytes) return tl::unexpected(bytes.error());
  progress_->clear();
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
