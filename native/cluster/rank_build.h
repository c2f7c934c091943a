#pragma once

#include <filesystem>

#include "native/builder/builder.h"
#include "native/cluster/transport.h"

namespace isosplat {

// One build by several processes, the ranks 0 to n − 1. All of them open the same volume with the
// same options. Rank 0 calls build_store_on_ranks, and then stop_ranks; the others call serve_rank.
//
// Rank 0 runs the StoreBuild and writes the store. Layer z of level 0 is read by rank (z + 1) mod
// n, and coarser levels are in rank 0's memory or temporary file. The rank that has the voxels of a
// block sends them to the rank that encodes it. This rank sends the encoded block, and its part of
// the coarser level, to rank 0. Rank 0 gives out each block with the λ and the size limit that it
// has in any build, so the store has the same bytes.

/// Builds a store into a sink: build_store with the threads of all ranks. options.threads and
/// options.memory_bytes are those of this rank. options.kept, only_isovalue and coarse_levels must
/// not be set. Errors: those of build_store; also of other ranks, whose number the message
/// contains.
Result<BuildReport> build_store_on_ranks(VolumeSource& source, ByteSink& sink,
                                         const BuildOptions& options, Transport& transport);

/// build_store_file with the threads of all ranks.
Result<BuildReport> build_store_file_on_ranks(VolumeSource& source,
                                              const std::filesystem::path& target,
                                              const BuildOptions& options, Transport& transport);

/// Tells all other ranks to end with this exit code, and waits until the messages are sent.
void stop_ranks(Transport& transport, int exit_code);

/// Reads and encodes what rank 0 asks for, until it sends `stop`. Errors are sent to rank 0.
/// Returns the exit code of `stop`.
int serve_rank(VolumeSource& source, const BuildOptions& options, Transport& transport);

/// Sends an error to rank 0, such as that the volume cannot be opened, and waits for `stop`.
/// Returns its exit code.
int refuse_rank(const Error& error, Transport& transport);

}  // namespace isosplat
