#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/core/builder/block_encoder.h"

namespace isosplat {

/// Blocks as messages, for encoders that have their own memory: a task with the voxels and
/// intervals that it needs, and the encoded block with its part of the coarser level. Both sides
/// are of the same version. Encoded blocks are also kept in files, whose readers check that the
/// version is theirs. Numbers are little-endian.

/// Writes a task to `message`, whose content is replaced. volume: its voxels at level 0.
void write_task(const Layer& layer, const CoarserLayer& coarser, const BlockTask& task,
                Index3 volume, std::vector<std::byte>& message);

/// Encodes the block of a task, and writes the result to `message`, whose content is replaced.
/// isovalue_distribution: that of the build, which tasks do not contain. Errors: invalid_argument
/// (the message is not one of write_task).
Result<void> encode_task(std::span<const std::byte> task,
                         std::span<const double> isovalue_distribution, BlockEncoder& encoder,
                         std::vector<std::byte>& message);

/// Writes a block that was encoded in place to `message`, whose content is replaced, as encode_task
/// writes it. `number`: of its task. Its part of `coarser` must have been written.
void write_encoded(const Layer& layer, const CoarserLayer& coarser, size_t number,
                   const EncodedBlock& encoded, std::vector<std::byte>& message);

/// Reads a result. Copies the block's part of the coarser level to its position in `coarser`.
/// Returns the number of the task. Errors: invalid_argument (the message is not one of encode_task
/// for a block of this layer).
Result<size_t> read_encoded(std::span<const std::byte> message, const Layer& layer,
                            const CoarserLayer& coarser, EncodedBlock& block);

}  // namespace isosplat
