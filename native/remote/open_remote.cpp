#include "native/remote/open_remote.h"

namespace isosplat::remote {

Result<std::shared_ptr<const HttpFile>> open_object(const std::string& address,
                                                    const RemoteOptions& options,
                                                    std::shared_ptr<HttpClient> client) {
  auto target = target_of(address, options.endpoint);
  if (!target) return tl::unexpected(target.error());
  return HttpFile::open(std::move(client), std::move(*target));
}

Result<std::shared_ptr<const HttpFile>> open_object(const std::string& address,
                                                    const RemoteOptions& options) {
  return open_object(address, options, std::make_shared<HttpClient>(options.http));
}

Result<FileParts> open_remote(const std::string& address, const RemoteOptions& options) {
  auto file = open_object(address, options);
  if (!file) return tl::unexpected(file.error());
  const uint64_t bytes = (*file)->bytes();
  return FileParts(std::move(*file), bytes);
}

Error store_error(Error error, const std::string& name) {
  if (error.status != Status::not_a_store) return error;
  return {
      Status::not_a_store,
      name +
          ": expected a store or a bundle, found another file: volumes are read from files only: "
          "download it first"};
}

Result<std::shared_ptr<StoreFile>> open_store(std::shared_ptr<const HttpFile> object) {
  const std::string name = object->name();
  const uint64_t bytes = object->bytes();
  auto store = StoreFile::open(FileParts(std::move(object), bytes), name);
  if (!store) return tl::unexpected(store_error(std::move(store.error()), name));
  return store;
}

}  // namespace isosplat::remote
