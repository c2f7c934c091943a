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

unsigned threads_for(const std::string& path, unsigned threads) {
  constexpr unsigned kRequests = 8;  // at the same time
  if (threads > 0 || !remote::is_address(path)) return threads;
  return std::max(kRequests, std::thread::hardware_concurrency());
}

Result<std::shared_ptr<StoreFile>> open_store(const std::string& path, const RemoteFlags& flags) {
  if (remote::is_address(path)) return remote::open_remote_store(path, flags.options());
  return StoreFile::open(path);
}

}  // namespace isosplat::cli
