#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "server/log/server_log.h"
#include "server/routes/metrics.h"
#include "server/routes/router.h"
#include "server/server.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// Reads the rules of access (tokens, keys, revoked links) into a router, and fetches the keys of
/// an identity provider while the server runs. Thread-safe, except as stated.
class AccessLoader {
 public:
  /// All must outlive it.
  AccessLoader(const ServerOptions& options, Router& router, ServerLog& log, Metrics& metrics,
               const std::atomic<bool>& stopping)
      : options_(options), router_(router), log_(log), metrics_(metrics), stopping_(stopping) {}
  ~AccessLoader() { join(); }

  /// Reads all files, and tries to fetch the keys. Errors: those of load().
  Result<void> prepare();

  /// Reads the files again for the following requests. Errors: io_error, invalid_argument; the
  /// router then keeps the old rules.
  Result<void> load();

  /// Whether there are rules, so that not every client may read every volume.
  bool has_rules() const { return has_rules_; }

  /// If the keys have a URL, starts a thread that fetches them regularly. Call once.
  void start();

  /// Asks the thread to fetch the keys soon.
  void want_keys();

  /// Ends the thread once `stopping` is set.
  void wake();
  void join();

 private:
  bool fetch_keys();
  void follow_keys();

  const ServerOptions& options_;
  Router& router_;
  ServerLog& log_;
  Metrics& metrics_;
  const std::atomic<bool>& stopping_;
  std::atomic<bool> has_rules_{false};
  std::mutex load_mutex_;
  std::string fetched_keys_;  // guarded by load_mutex_
  std::mutex mutex_;
  std::condition_variable changed_;
  bool are_keys_wanted_ = false;  // guarded by mutex_
  std::thread thread_;            // of follow_keys()
};

}  // namespace isosplat::server
