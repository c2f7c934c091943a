#include "native/cli/building.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <span>

#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/files/output_file.h"
#include "shared/core/store/format.h"

namespace isosplat::cli {

namespace {

/// Calls build(options) with the notes of the volume, and shows its progress.
template <class Build>
auto with_progress(const import::OpenVolume& volume, const std::filesystem::path& target,
                   BuildOptions options, Build build) -> decltype(build(options)) {
  if (auto other = check_not_input(target, volume.source->files()); !other) {
    return tl::unexpected(other.error());
  }
  options.notes = volume.notes;
  for (const std::string& text : options.notes) note(text);
  ProgressLine line(fmt::format("Building {}", target.filename().string()));
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
  ClampedVoxels clamped;
  options.clamped = &clamped;
  auto built = build(options);
  line.clear();
  note_clamped(clamped);
  return built;
}

}  // namespace

Result<BuildReport> build_with_progress(const import::OpenVolume& volume,
                                        const std::filesystem::path& store, BuildOptions options,
                                        const StoreBuilder& builder) {
  return with_progress(volume, store, std::move(options), [&](const BuildOptions& all) {
    return builder(*volume.source, store, all);
  });
}

Result<PartReport> build_part_with_progress(const import::OpenVolume& volume,
                                            const std::filesystem::path& path, BuildOptions options,
                                            Part part) {
  return with_progress(volume, path, std::move(options), [&](const BuildOptions& all) {
    return build_part_file(*volume.source, path, all, part);
  });
}

void note_clamped(const ClampedVoxels& clamped) {
  if (clamped.below + clamped.above == 0) return;
  note(fmt::format("--range: {} voxels below and {} above it have the values of its ends",
                   with_commas(clamped.below), with_commas(clamped.above)));
}

std::string store_stem(const std::filesystem::path& volume) {
  // In the order in which they end a name: "x.ome.tiff.gz". Other suffixes may be a part of the
  // name, as in the names of DICOM files.
  constexpr std::array kCompressed{".gz", ".bz2", ".zst", ".xz"};
  constexpr std::array kFormats{
      ".nii", ".nrrd", ".nhdr", ".mha",  ".mhd",  ".hdr",    ".img",  ".vtk",  ".vti",  ".pvti",
      ".vtr", ".pvtr", ".vts",  ".pvts", ".vth",  ".vthb",   ".vtu",  ".pvtu", ".tif",  ".tiff",
      ".lsm", ".stk",  ".dcm",  ".raw",  ".mgh",  ".cube",   ".cub",  ".xsf",  ".dx",   ".mgz",
      ".npy", ".npz",  ".mrc",  ".map",  ".ccp4", ".rec",    ".st",   ".h5",   ".hdf5", ".he5",
      ".nc",  ".ims",  ".mat",  ".emd",  ".cmap", ".vtkhdf", ".zarr", ".zip"};
  constexpr std::array kInner{".ome"};
  const auto name = volume.has_filename() ? volume : volume.parent_path();
  std::filesystem::path stem = name.filename();
  const auto strip = [&](std::span<const char* const> suffixes) {
    std::string suffix = stem.extension().string();
    std::ranges::transform(suffix, suffix.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (std::ranges::find(suffixes, suffix) != suffixes.end()) stem = stem.stem();
  };
  strip(kCompressed);
  strip(kFormats);
  strip(kInner);
  return stem.string();
}

bool is_store(const std::filesystem::path& path) {
  const std::string beginning = first_bytes(path, kStoreMagic.size());
  return beginning.size() == kStoreMagic.size() &&
         std::memcmp(beginning.data(), kStoreMagic.data(), kStoreMagic.size()) == 0;
}

}  // namespace isosplat::cli
