#include "server/tls_loader.h"

#include <fmt/format.h>

#include <ctime>
#include <utility>

namespace isosplat::server {

Result<void> TlsLoader::load() {
  if (options_.tls_certificate.empty() && options_.tls_key.empty()) return {};
  auto loaded = load_tls(options_.tls_certificate, options_.tls_key);
  if (!loaded) return tl::unexpected(loaded.error());
  const int64_t end = certificate_end(**loaded);
  metrics_.certificate_end = end;
  constexpr int64_t kDay = 24 * 3600, kWarned = 14 * kDay;
  const int64_t left = end - std::time(nullptr);
  if (left < kWarned) {
    log_.line(left < 0
                  ? fmt::format("warning: {}: the certificate has ended: clients will refuse it",
                                options_.tls_certificate.string())
                  : fmt::format("warning: {}: the certificate ends in {} days: renew it",
                                options_.tls_certificate.string(), left / kDay));
  }
  const std::lock_guard lock(mutex_);
  tls_ = std::move(*loaded);
  return {};
}

std::shared_ptr<TlsContext> TlsLoader::context() {
  const std::lock_guard lock(mutex_);
  return tls_;
}

}  // namespace isosplat::server
