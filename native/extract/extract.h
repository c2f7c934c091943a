#pragma once

#include <functional>
#include <vector>

#include "shared/points/chunk_samples.h"
#include "shared/sampling/packed_sample.h"
#include "shared/store_file/store_file.h"

namespace isosplat {

struct ExtractOptions {
  uint32_t level = 0;
  unsigned threads = 0;  ///< 0: one per core
};

/// The samples of one chunk, as the GPU takes them.
struct ChunkSamples {
  ChunkRef chunk;
  std::vector<PackedSample> samples;
};

/// Everything that is to be drawn for an isovalue at one level: for each block that the isosurface
/// may cross its one chunk, decoded. Chunks hold some cells beside the active ones, which the
/// vertex shader drops. In file order. Replaces the content of `result`, and uses its memory again:
/// pass the same one for the next isovalue. Errors: not_found (no such level), invalid_argument
/// (the isovalue is not a number), out_of_memory (the system refuses memory or threads), and those
/// of StoreFile and ChunkDecoder; `result` is then empty.
Result<void> extract_samples(const StoreFile& store, double isovalue, const ExtractOptions& options,
                             std::vector<ChunkSamples>& result);

/// Points on the isosurface with unit normals towards smaller values: one for each active cell,
/// unless `projection` drops some. Hands them to `take` chunk by chunk in file order, from the
/// calling thread; at most a few chunks are held at a time. Returns how many points there were.
/// Errors: as extract_samples, and the first error of `take`, which ends the work.
Result<uint64_t> extract_points(const StoreFile& store, double isovalue,
                                const ProjectionOptions& projection, const ExtractOptions& options,
                                const std::function<Result<void>(const PointArrays&)>& take);

}  // namespace isosplat
