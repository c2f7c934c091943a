#pragma once

#include <memory>
#include <mutex>

#include "server/log/server_log.h"
#include "server/net/tls.h"
#include "server/routes/metrics.h"
#include "server/server.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// The certificate and the key of a server. Thread-safe.
class TlsLoader {
 public:
  /// All must outlive it.
  TlsLoader(const ServerOptions& options, ServerLog& log, Metrics& metrics)
      : options_(options), log_(log), metrics_(metrics) {}

  /// If the options name the two files, reads them for new connections. Errors: those of
  /// load_tls(); the previous certificate is kept then.
  Result<void> load();

  /// Null without TLS.
  std::shared_ptr<TlsContext> context();

 private:
  const ServerOptions& options_;
  ServerLog& log_;
  Metrics& metrics_;
  std::mutex mutex_;
  std::shared_ptr<TlsContext> tls_;  // guarded by mutex_
};

}  // namespace isosplat::server
