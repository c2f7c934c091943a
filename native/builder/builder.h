#pragma once

#include <filesystem>

#include "native/builder/clamped_source.h"
#include "shared/core/builder/store_options.h"
#include "shared/core/grid/volume_source.h"
#include "shared/core/store/store_writer.h"

namespace isosplat {

class KeptBlocks;

struct BuildOptions : StoreOptions {
  unsigned threads = 0;  ///< 0: one per core. The store does not depend on the number.
  /// Folder for coarse levels that do not fit in memory; empty: the target's folder, or the
  /// system's folder for temporary files.
  std::filesystem::path temporary_folder;
  /// If set, it determines the mapping to quantized values; `scan` and the voxels do not. Values
  /// outside of the range are set to its ends. The volume is read once less. Integers of up to 16
  /// bits, and wider ones if the range has at most 65536 of them, stay lossless.
  std::optional<ValueRange> range;
  ClampedVoxels* clamped = nullptr;  ///< if not null, receives what `range` has changed
  KeptBlocks* kept = nullptr;        ///< encoded blocks that the build takes and keeps, if any
  /// Text that identifies the content of the volume, for kept blocks and for parts, because
  /// StoreBuild::key() covers only a sample of it.
  std::string content_key;
};

/// The smallest memory_bytes with which a store of this volume can be built.
uint64_t min_memory(const VolumeSource& source, const BuildOptions& options);

/// The number of threads of a build with these options.
unsigned thread_count(const BuildOptions& options);

/// Scans a volume for StoreOptions::scan, as a build without it would. Errors: those of the source;
/// out_of_memory.
Result<VoxelScan> scan_for_build(VolumeSource& source, const BuildOptions& options);

/// Builds a store into a sink: StoreBuild, with threads and temporary files. Errors: those of
/// StoreBuild and KeptBlocks; out_of_memory, also if the system refuses memory or threads.
Result<BuildReport> build_store(VolumeSource& source, ByteSink& sink, const BuildOptions& options);

/// Builds a store file. It appears under the name `target` when it is complete. If the build fails,
/// an existing file of this name is unchanged. Errors: also those of OutputFile.
Result<BuildReport> build_store_file(VolumeSource& source, const std::filesystem::path& target,
                                     const BuildOptions& options);

}  // namespace isosplat
