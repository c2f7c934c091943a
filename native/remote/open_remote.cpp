#include "native/remote/open_remote.h"

#include "native/remote/http_file.h"

namespace isosplat::remote {

Result<FileParts> open_remote(const std::string& address, const RemoteOptions& options) {
  auto target = target_of(address, options.endpoint);
  if (!target) return tl::unexpected(target.error());
  auto file = HttpFile::open(std::make_shared<HttpClient>(options.http), std::move(*target));
  if (!file) return tl::unexpected(file.error());
  const uint64_t bytes = (*file)->bytes();
  return FileParts(std::move(*file), bytes);
}

Error store_error(Error error, const std::string& name) {
  if (error.status != Status::not_a_store) return error;
  return {Status::not_a_store,
          name +
              ": expected a store, found another file: scenes, bundles and volumes are read from "
              "files only: download it first"};
}

Result<std::shared_ptr<StoreFile>> open_remote_store(const std::string& address,
                                                     const RemoteOptions& options) {
  auto parts = open_remote(address, options);
  if (!parts) return tl::unexpected(parts.error());
  const std::string name = parts->file().name();
  auto store = StoreFile::open(std::move(*parts), name);
  if (!store) return tl::unexpected(store_error(std::move(store.error()), name));
  return store;
}

}  // namespace isosplat::remote
