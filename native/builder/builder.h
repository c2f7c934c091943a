#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "native/import/volume_source.h"
#include "shared/store/store_writer.h"

namespace isosplat {

/// How far a build is.
struct BuildProgress {
  const char* phase = "";        ///< "reading the value range", "level 0", …, "finishing"
  double fraction = 0;           ///< of the whole build, 0 to 1
  double voxels_per_second = 0;  ///< of the input, since encoding began
  double seconds_left = 0;       ///< an estimate; 0 while unknown
};

struct BuildOptions {
  std::string title;        ///< for people; empty: the source's name
  std::string value_units;  ///< "HU", …; empty: unknown
  /// What a person should know of how the volume was read; kept in the store's metadata.
  std::vector<std::string> notes;
  std::string source_file;  ///< for the metadata (FORMAT.md): name of the volume's file or folder;
  std::string source_path_hash;  ///< and its path's hash; empty: unknown
  /// How much a byte fetched for an isovalue weighs against a byte stored, above 0; 1 is the
  /// default. More makes stores larger and isovalues smaller. The store takes at most √fetch_weight
  /// times the bytes of the voxels or of their quantized values, whichever are fewer, if it can.
  double fetch_weight = 1;
  /// How far a value may be from the voxel's: 0 for lossless where 16 bits allow, else as exact as
  /// they do. Larger ones make smaller stores. See choose_quantization.
  double max_error = 0;
  /// Most memory that the build may take, in bytes, with what the source holds itself.
  uint64_t memory_bytes = uint64_t{1} << 30;
  unsigned threads = 0;  ///< 0: one per core. The store is the same whatever the number.
  /// Where coarse levels wait that do not fit in memory; empty: the target's folder, or the
  /// system's for temporary files.
  std::filesystem::path temporary_folder;
  /// Called now and then from one of the build's threads, one at a time.
  std::function<void(const BuildProgress&)> progress;
};

struct BuildReport {
  StoreInfo info;
  uint64_t raw_bytes = 0;     ///< of the volume's voxels as they are in the file
  uint64_t max_bytes = 0;     ///< that the store was to take: noise may need more
  uint64_t needed_bytes = 0;  ///< of memory, by the build's own account
  bool uses_temporary_files = false;
  double seconds = 0;
};

/// The least memory with which this volume can be built, in bytes, with what the source holds.
uint64_t min_memory(const VolumeSource& source, const BuildOptions& options);

/// Builds a store into a sink. A few slices of the source are read first, then all, front to back;
/// before both all of it for the range of its values, unless the first slices show that integers of
/// up to 16 bits are their own codes. Errors: those of choose_quantization, no_cells,
/// volume_too_large, out_of_memory (before anything is read; says how much it needs), io_error, and
/// what the source returns.
Result<BuildReport> build_store(VolumeSource& source, ByteSink& sink, const BuildOptions& options);

/// Builds a store file. It appears under `target` when it is whole; whatever happens before, a file
/// of that name stays as it was. Errors: also those of OutputFile.
Result<BuildReport> build_store_file(VolumeSource& source, const std::filesystem::path& target,
                                     const BuildOptions& options);

}  // namespace isosplat
