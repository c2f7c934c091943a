#pragma once

#include "native/builder/verify.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat {

/// Checks the fields of a store whose other chunks are valid (verify_store):
/// - each field hashes to its content id, and its header is the one that the store's header lists;
/// - its directory has the blocks, bands and cells of the store, and its chunks are contiguous;
/// - each field chunk decodes, and a lattice point has the same value in all bands of a block;
/// - the values lie within the field's range, or are missing in a field that has missing values.
/// Returns the number of field chunks. Errors: the first check that fails.
Result<uint64_t> verify_fields(const StoreFile& store, const VerifyOptions& options);

/// Whether the bytes after a header and the header itself hash to the content id. `file`: a store
/// or a field. Errors: checksum_mismatch, and those of the file.
Result<void> verify_content(const FileParts& file, const StoreInfo& info);

}  // namespace isosplat
