#pragma once

#include <string>

#include "native/remote/http_client.h"
#include "shared/system/posix_file/file_parts.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::remote {

struct RemoteOptions {
  std::string endpoint;  ///< see target_of()
  HttpOptions http;
};

/// Opens the object at an address for reading by ranges. Errors: those of target_of() and
/// HttpFile::open().
Result<FileParts> open_remote(const std::string& address, const RemoteOptions& options);

/// The error of reading an object as a store, with another remedy if it is not_a_store: of scenes,
/// bundles and volumes, only files are read.
Error store_error(Error error, const std::string& name);

/// Opens the store at an address. Its path, for messages, is the address without credentials.
/// Errors: those of open_remote() and StoreFile::open(), as by
/// store_error().
Result<std::shared_ptr<StoreFile>> open_remote_store(const std::string& address,
                                                     const RemoteOptions& options);

}  // namespace isosplat::remote
