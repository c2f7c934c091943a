#pragma once

#include <string>

#include "native/remote/http_file.h"
#include "shared/system/posix_file/file_parts.h"
#include "shared/system/store_file/store_file.h"

namespace isosplat::remote {

struct RemoteOptions {
  std::string endpoint;  ///< see target_of()
  HttpOptions http;
};

/// Opens the object at an address. `client`: sends the requests. Errors: those of target_of() and
/// HttpFile::open().
Result<std::shared_ptr<const HttpFile>> open_object(const std::string& address,
                                                    const RemoteOptions& options,
                                                    std::shared_ptr<HttpClient> client);

/// The same with a client of its own.
Result<std::shared_ptr<const HttpFile>> open_object(const std::string& address,
                                                    const RemoteOptions& options);

/// Opens the object at an address for reading by ranges. Errors: those of open_object().
Result<FileParts> open_remote(const std::string& address, const RemoteOptions& options);

/// The error of reading an object as a store, with another remedy if it is not_a_store: of volumes,
/// only files are read.
Error store_error(Error error, const std::string& name);

/// Opens an object as a store. Its path, for messages, is the object's name. Errors: those of
/// StoreFile::open(), as by store_error().
Result<std::shared_ptr<StoreFile>> open_store(std::shared_ptr<const HttpFile> object);

}  // namespace isosplat::remote
