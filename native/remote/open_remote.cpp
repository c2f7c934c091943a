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

Result<std::shared_ptr<StoreFile>> open_remote_store(const std::string& address,
                                                     const RemoteOptions& options) {
  auto parts = open_remote(address, options);
  if (!parts) return tl::unexpected(parts.error());
  const std::string name = parts->file().name();
  return StoreFile::open(std::move(*parts), name);
}

}  // namespace isosplat::remote
