#pragma once

#include <stdint.h>

/// The functions with which the module `isosplat-import` reads files. JavaScript implements them
/// (import_host.js). Paths are UTF-8, relative, with "/" between their parts.
#ifdef __cplusplus
extern "C" {
#endif

enum { ISOSPLAT_FILE_NONE = -1, ISOSPLAT_FILE_FOLDER = -2 };

/// The number of the file at a path, from 0; or one of the above.
int32_t isosplat_file_find(const char* path, uint32_t bytes);

double isosplat_file_bytes(int32_t file);

/// When the file was changed, in milliseconds since 1970; 0 if that is unknown.
double isosplat_file_modified(int32_t file);

/// Reads up to `bytes` bytes from an offset. Returns their number; below 0 if the browser cannot
/// read the file: then isosplat_file_error has the reason.
int32_t isosplat_file_read(int32_t file, double offset, void* out, uint32_t bytes);

/// Copies a reason as UTF-8 to `text`, up to `limit` bytes. Returns its size.
uint32_t isosplat_file_error(char* text, uint32_t limit);

/// The content of a folder: each name has "f" (a file) or "d" (a folder) before it and a null after
/// it. Copies up to `limit` bytes to `text`. Returns the size of the whole list.
uint32_t isosplat_folder_names(const char* path, uint32_t bytes, char* text, uint32_t limit);

#ifdef __cplusplus
}
#endif
