#pragma once

#include "tests/native/volume_files.h"

// Checks of the result of opening a volume: the volume, its notes, or an error.
namespace isosplat::test {

inline import::OpenVolume open(const std::filesystem::path& path,
                               const import::ImportOptions& options = {}) {
  auto volume = import::open_volume(path, options);
  EXPECT_TRUE(volume) << volume.error().message;
  return volume ? std::move(*volume) : import::OpenVolume{};
}

/// The error of opening the file or of reading it; empty if there is none.
inline std::string error_of(const std::filesystem::path& path,
                            const import::ImportOptions& options = {}) {
  auto volume = import::open_volume(path, options);
  if (!volume) return volume.error().message;
  const VolumeHeader& header = volume->source->header();
  const Index3 n = header.grid.voxels;
  std::vector<std::byte> out(static_cast<size_t>(n.x * n.y * n.z) * voxel_bytes(header.type));
  const auto read = volume->source->read_slices(0, n.z, out);
  return read ? "" : read.error().message;
}

inline void expect_error(const std::filesystem::path& path, const std::string& part,
                         const import::ImportOptions& options = {}) {
  const std::string error = error_of(path, options);
  EXPECT_NE(error, "");
  EXPECT_NE(error.find(part), std::string::npos) << error;
}

/// Expects that one of the notes contains `part`.
inline void expect_note(const import::OpenVolume& volume, const std::string& part) {
  for (const std::string& note : volume.notes) {
    if (note.find(part) != std::string::npos) return;
  }
  ADD_FAILURE() << "no note contains \"" << part
                << "\": " << ::testing::PrintToString(volume.notes);
}

/// The choices that a file offers if no volume is chosen.
inline std::vector<import::VolumeChoice> offered_choices(const std::filesystem::path& path) {
  std::vector<import::VolumeChoice> choices;
  import::ImportOptions options;
  options.choices = &choices;
  EXPECT_FALSE(import::open_volume(path, options));
  return choices;
}

}  // namespace isosplat::test
