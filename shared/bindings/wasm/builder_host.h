#pragma once

#include <stdint.h>

/// The JavaScript functions that the module `isosplat-builder` calls (builder_host.js). A status of
/// 0 is ok, 1 an io_error, whose message is the text of isosplat_host_error.
#ifdef __cplusplus
extern "C" {
#endif

/// Reads slices [first, first + count) of the volume to `out`: native-endian voxels, x fastest.
uint32_t isosplat_host_read_slices(uint32_t first, uint32_t count, void* out, uint32_t bytes);

/// Writes bytes of the store at an offset.
uint32_t isosplat_host_write(double offset, const void* data, uint32_t bytes);

/// Copies the message of the last error as UTF-8 to `text`, up to `limit` bytes. Returns its size.
uint32_t isosplat_host_error(char* text, uint32_t limit);

/// The progress of a build: BuildProgress.
void isosplat_host_progress(double fraction, double voxels_per_second, double seconds_left);

#ifdef __cplusplus
}
#endif
