#pragma once

#include <stdint.h>

/// Volume files for JavaScript: the readers of shared/import. The module `isosplat-import` exports
/// these functions; web/import wraps them. The page loads it only when a volume is to be read.
///
/// The rules are those of core_api.h: a status of 0 is ok; result buffers belong to the importer
/// and stay valid until its next call; memory that a function reads belongs to the caller; every
/// call may grow the heap. The files are those of import_host.h.
#ifdef __cplusplus
extern "C" {
#endif

typedef struct IsosplatImport IsosplatImport;

IsosplatImport* isosplat_import_create(void);
void isosplat_import_destroy(IsosplatImport* importer);

/// The message of the last error, and the name of a status: UTF-8, null-terminated.
const char* isosplat_import_error(const IsosplatImport* importer);
const char* isosplat_import_status_name(uint32_t status);

/// The result of the last call, and its size in bytes.
const void* isosplat_import_result(const IsosplatImport* importer);
uint32_t isosplat_import_result_bytes(const IsosplatImport* importer);

/// Determines the format of a file from its first bytes and its name. Result: the name of the
/// format; empty if no reader accepts it.
uint32_t isosplat_import_detect(IsosplatImport* importer, const char* path, uint32_t bytes);

/// How a file is compressed, if JavaScript must unpack it before it is opened. Result:
/// packing_of_file.
uint32_t isosplat_import_packing(IsosplatImport* importer, const char* path, uint32_t bytes);

/// The volumes of a file that has several. Result: a JSON list of VolumeChoice in
/// web/import/types.ts, empty if no choice is needed. Errors: those of volumes_in_file.
uint32_t isosplat_import_choices(IsosplatImport* importer, const char* path, uint32_t bytes);

/// Opens a volume. `request`: JSON text, {"path", "options": ImportOptions in web/import/types.ts}.
/// Result: JSON text, ImportedVolume in web/import/types.ts. Errors: invalid_argument, and those of
/// open_volume.
uint32_t isosplat_import_open(IsosplatImport* importer, const char* request, uint32_t bytes);

/// Reads slices [first, first + count) of the open volume. Result: native-endian voxels, x fastest.
/// Errors: invalid_argument, those of VolumeSource::read_slices.
uint32_t isosplat_import_read_slices(IsosplatImport* importer, uint32_t first, uint32_t count);

#ifdef __cplusplus
}
#endif
