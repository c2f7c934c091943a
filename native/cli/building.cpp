#include "native/cli/building.h"

#include <fmt/format.h>

#include <cstring>

#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/files/output_file.h"
#include "shared/store/format.h"

namespace isosplat::cli {

Result<BuildReport> build_with_progress(const OpenVolume& volume,
                                        const std::filesystem::path& store, BuildOptions options) {
  if (auto other = check_not_input(store, volume.source->files()); !other) {
    return tl::unexpected(other.error());
  }
  options.notes = volume.notes;
  for (const std::string& text : options.notes) note(text);
  ProgressLine line(fmt::format("Building {}", store.filename().string()));
  line.show(0, "opened");
  options.progress = [&](const BuildProgress& progress) {
    std::string detail = progress.phase;
    if (progress.voxels_per_second > 0) {
      detail += fmt::format(", {:.0f} million voxels/s", progress.voxels_per_second / 1e6);
    }
    if (progress.seconds_left > 0) {
      detail += fmt::format(", {} left", format_seconds(progress.seconds_left));
    }
    line.show(progress.fraction, detail);
  };
  return build_store_file(*volume.source, store, options);
}

std::string store_stem(const std::filesystem::path& volume) {
  const auto name = volume.has_filename() ? volume : volume.parent_path();
  std::string stem = name.filename().string();
  for (const std::string_view suffix :
       {".gz", ".nii", ".nrrd", ".nhdr", ".mha", ".mhd", ".vtk", ".tif", ".tiff", ".dcm", ".raw"}) {
    if (stem.size() > suffix.size() && stem.ends_with(suffix)) {
      stem.resize(stem.size() - suffix.size());
    }
  }
  return stem;
}

bool is_store(const std::filesystem::path& path) {
  const std::string beginning = first_bytes(path, kStoreMagic.size());
  return beginning.size() == kStoreMagic.size() &&
         std::memcmp(beginning.data(), kStoreMagic.data(), kStoreMagic.size()) == 0;
}

}  // namespace isosplat::cli
