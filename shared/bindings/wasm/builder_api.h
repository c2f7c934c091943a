#pragma once

#include <stdint.h>

/// The builder for JavaScript: builds stores from slices, and encodes their blocks. The module
/// `isosplat-builder` exports these functions; web/builder wraps them. The page loads it only when
/// a volume is to be built.
///
/// The rules are those of core_api.h: a status of 0 is ok; result buffers belong to the builder and
/// stay valid until its next call; memory that a function reads belongs to the caller; every call
/// may grow the heap.
///
/// An IsosplatBuilder either directs one build or encodes blocks. A build reads slices and writes
/// the store through builder_host.h. Blocks travel as messages
/// (shared/core/builder/block_transfer.h) between instances of the module in different workers:
///
///     begin → setup message for every encoder
///     next → a task message → encode → a block message → add          until next says `complete`
///     statistics → add_statistics                                     of every encoder
///     finish
#ifdef __cplusplus
extern "C" {
#endif

typedef struct IsosplatBuilder IsosplatBuilder;

/// The second result of isosplat_builder_next.
enum {
  ISOSPLAT_NEXT_TASK,     ///< the first result is a task
  ISOSPLAT_NEXT_WAIT,     ///< blocks that are being encoded must be added first
  ISOSPLAT_NEXT_COMPLETE  ///< all blocks were added
};

IsosplatBuilder* isosplat_builder_create(void);
void isosplat_builder_destroy(IsosplatBuilder* builder);

/// The message of the last error, and the name of a status: UTF-8, null-terminated.
const char* isosplat_builder_error(const IsosplatBuilder* builder);
const char* isosplat_builder_status_name(uint32_t status);

/// Result buffer 0 or 1, and its size in bytes.
const void* isosplat_builder_result(const IsosplatBuilder* builder, uint32_t buffer);
uint32_t isosplat_builder_result_bytes(const IsosplatBuilder* builder, uint32_t buffer);

/// Begins a build. `volume`: JSON text, see VolumeDescription in web/builder/types.ts. Reads the
/// source for the value range and a sample. Result 0: the setup message. Errors: invalid_argument,
/// and those of StoreBuild::begin.
uint32_t isosplat_builder_begin(IsosplatBuilder* builder, const char* volume, uint32_t bytes);

/// The next task, if there is one now. Reads the slices of the next layer when the present one is
/// complete. Results: the task; a uint32_t, ISOSPLAT_NEXT_….
uint32_t isosplat_builder_next(IsosplatBuilder* builder);

/// Adds an encoded block.
uint32_t isosplat_builder_add(IsosplatBuilder* builder, const void* block, uint32_t bytes);

/// Adds the statistics of an encoder.
uint32_t isosplat_builder_add_statistics(IsosplatBuilder* builder, const void* statistics,
                                         uint32_t bytes);

/// Writes the remaining parts of the store. Result 0: JSON text, see BuildReport in
/// web/builder/types.ts.
uint32_t isosplat_builder_finish(IsosplatBuilder* builder);

/// Makes the builder an encoder. `setup`: result of isosplat_builder_begin.
uint32_t isosplat_builder_set_up(IsosplatBuilder* builder, const void* setup, uint32_t bytes);

/// Encodes the block of a task. Result 0: the block message.
uint32_t isosplat_builder_encode(IsosplatBuilder* builder, const void* task, uint32_t bytes);

/// Result 0: the statistics of the blocks that this encoder has encoded.
uint32_t isosplat_builder_statistics(IsosplatBuilder* builder);

#ifdef __cplusplus
}
#endif
