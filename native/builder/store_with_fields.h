#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "native/builder/builder.h"
#include "shared/core/categories/categories.h"
#include "shared/system/posix_file/file_parts.h"

namespace isosplat {

/// A field to build. `open` is called when the store is complete, so that only one volume besides
/// the store's is in memory.
struct FieldInput {
  std::string name;
  std::string source_file;  ///< for the field's metadata
  std::function<Result<std::unique_ptr<VolumeSource>>()> open;
  std::vector<std::string> notes = {};
  std::vector<Category> categories = {};  ///< if its values are labels
};

/// Writes a store with these fields (StoreKind::field), in this order: the fields, the chunks of
/// the store as they are, and its directory with the new offsets. `store`: a store without fields.
/// Errors: those of the files and the sink, and of damaged headers and pages; invalid_argument (two
/// fields have one name, or there are too many).
Result<StoreInfo> write_store_with_fields(const FileParts& store, std::span<const FileParts> fields,
                                          ByteSink& sink);

/// As build_store, for a store with fields. The store without fields, and then each field, is built
/// to a temporary file in options.temporary_folder. The memory of `source` counts for the fields
/// too. `target`: for messages. Errors: also those of build_field and FieldInput::open.
Result<BuildReport> build_store_with_fields(VolumeSource& source,
                                            std::span<const FieldInput> fields, ByteSink& sink,
                                            const std::filesystem::path& target,
                                            const BuildOptions& options);

/// The same as a file. Errors: also those of OutputFile.
Result<BuildReport> build_store_with_fields(VolumeSource& source,
                                            std::span<const FieldInput> fields,
                                            const std::filesystem::path& target,
                                            const BuildOptions& options);

}  // namespace isosplat
