#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/core/preprocess/layer.h"
#include "shared/core/preprocess/voxel_scan.h"
#include "shared/core/store/store_reader.h"

namespace isosplat {

/// Progress of a build.
struct BuildProgress {
  const char* phase = "";        ///< "reading the value range", "level 0", …, "finishing"
  double fraction = 0;           ///< of the whole build, 0 to 1
  double voxels_per_second = 0;  ///< of all levels, since encoding began
  double seconds_left = 0;       ///< an estimate; 0 while unknown
};

/// The options that determine the bytes of a store, besides the volume, and the limits of a build.
struct StoreOptions {
  std::string title;        ///< for display; empty: the source's name
  std::string value_units;  ///< "HU", …; empty: unknown
  /// Assumptions made when the volume was read, for display; kept in the store's metadata.
  std::vector<std::string> notes;
  std::string source_file;  ///< name of the volume's file or folder, for the metadata (FORMAT.md)
  std::string source_path_hash;  ///< hash of its path, for the metadata; empty: unknown
  /// How important the bytes fetched for an isovalue are, relative to the bytes stored; above 0 (1:
  /// the default). A larger weight gives larger stores and smaller fetches. Size limit of the
  /// store: √fetch_weight × the bytes of the voxels or of their quantized values, whichever is
  /// smaller. Noisy volumes may exceed it.
  double fetch_weight = 1;
  /// Largest difference between a stored value and the voxel's, in the volume's units. 0: lossless
  /// if 16 bits allow it, else with the precision of 16 bits. See choose_quantization.
  double max_error = 0;
  /// If set, the store is for this isovalue alone, such as the border of a label. Cells of level 0
  /// that are not active at this isovalue are left out, as if a voxel were missing there. The store
  /// is smaller, and its surfaces at other isovalues are incomplete. Its metadata has no histogram,
  /// and one bin of active cells.
  std::optional<double> only_isovalue;
  /// How the coarse levels are built, such as by DistanceLevels. Must outlive the build. Null: by
  /// averages.
  const CoarseLevels* coarse_levels = nullptr;
  /// The scan of all volumes that share one mapping to quantized values, such as the steps of a
  /// series. It includes this volume, and has the type of its voxels. Null: the mapping depends on
  /// this volume alone.
  std::shared_ptr<const VoxelScan> scan;
  /// Memory limit of the build in bytes, including the memory of the source.
  uint64_t memory_bytes = uint64_t{1} << 30;
  /// Called at most every 50 ms, one call at a time, from whichever thread reads or adds a block.
  std::function<void(const BuildProgress&)> progress;
};

struct BuildReport {
  StoreInfo info;
  uint64_t raw_bytes = 0;     ///< of the voxels, in their original type
  uint64_t max_bytes = 0;     ///< size limit of the store; noisy volumes may exceed it
  uint64_t needed_bytes = 0;  ///< of memory, as planned (MemoryPlan)
  bool uses_temporary_files = false;
  double seconds = 0;
};

}  // namespace isosplat
