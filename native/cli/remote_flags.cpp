#include "native/cli/remote_flags.h"

#include <algorithm>
#include <thread>

#include "native/cli/numbers.h"
#include "native/remote/remote_target.h"

namespace isosplat::cli {

void RemoteFlags::add_to(CLI::App& command) {
  command
      .add_option("--endpoint", endpoint_,
                  "Host of s3:// addresses, such as https://minio.example:9000 (default:\n"
                  "AWS_ENDPOINT_URL, or AWS)")
      ->option_text("URL");
  command
      .add_option("--timeout", timeout_s_,
                  "Addresses: seconds without data after which a request is repeated")
      ->check(is_whole_number(1, 3600))
      ->capture_default_str();
}

remote::RemoteOptions RemoteFlags::options() const {
  remote::RemoteOptions options;
  options.endpoint = endpoint_;
  options.http.stall_s = timeout_s_;
  return options;
}

Result<std::shared_ptr<const remote::HttpFile>> RemoteFlags::object(
    const std::string& address) const {
  if (address == address_) return object_;
  if (!client_) client_ = std::make_shared<remote::HttpClient>(options().http);
  address_.clear();
  object_ = nullptr;  // frees what was read of the last one
  object_ = remote::open_object(address, options(), client_);
  address_ = address;
  return object_;
}

SceneKind scene_kind(const std::string& path, const RemoteFlags& flags) {
  if (!remote::is_address(path)) return isosplat::scene_kind(path);
  const auto object = flags.object(path);
  return object ? isosplat::scene_kind(**object, (*object)->bytes()) : SceneKind::none;
}

Result<SceneFile> open_scene(const std::string& path, const RemoteFlags& flags) {
  if (!remote::is_address(path)) return SceneFile::open(path);
  const auto object = flags.object(path);
  if (!object) return tl::unexpected(object.error());
  const std::string& name = (*object)->name();
  if (scene_kind(path, flags) == SceneKind::scene) {
    return fail(Status::invalid_argument,
                name +
                    ": expected a store or a bundle, found the document of a scene, whose stores "
                    "are other files: make a bundle of it with isosplat bundle");
  }
  return SceneFile::open(*object, (*object)->bytes(), name);
}

unsigned threads_for(const std::string& path, unsigned threads) {
  constexpr unsigned kRequests = 8;  // at the same time
  if (threads > 0 || !remote::is_address(path)) return threads;
  return std::max(kRequests, std::thread::hardware_concurrency());
}

Result<std::shared_ptr<StoreFile>> open_store(const std::string& path, const RemoteFlags& flags) {
  if (!remote::is_address(path)) return StoreFile::open(path);
  auto object = flags.object(path);
  if (!object) return tl::unexpected(object.error());
  return remote::open_store(std::move(*object));
}

}  // namespace isosplat::cli
