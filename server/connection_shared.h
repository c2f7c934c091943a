#pragma once

#include <atomic>

#include "server/access/trusted_proxies.h"
#include "server/limits/byte_budget.h"
#include "server/limits/rate_limit.h"
#include "server/limits/work_pool.h"
#include "server/log/access_log.h"
#include "server/log/server_log.h"
#include "server/routes/metrics.h"
#include "server/routes/router.h"
#include "server/server.h"

namespace isosplat::server {

/// State that all connections of a server share. Must outlive them.
struct ConnectionShared {
  const Router& router;
  const ServerLimits& limits;
  const std::atomic<bool>& stopping;
  ServerLog& log;
  WorkPool& disk;       ///< for reads that wait for disks
  WorkPool& headers;    ///< the same, for routes that read headers of many stores
  WorkPool& computing;  ///< for routes that compute
  Metrics& metrics;
  RateLimit& rates;
  ByteBudget& bytes_in_flight;
  LogFormat log_format;
  const TrustedProxies& proxies;
  bool has_tls;  ///< whether the server has TLS: connections without TLS are then only redirected
};

}  // namespace isosplat::server
