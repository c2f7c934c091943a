#pragma once

#include <atomic>
#include <string>
#include <thread>

#include "server/catalog/catalog.h"
#include "server/catalog/scene_pool.h"
#include "server/catalog/store_pool.h"
#include "server/log/server_log.h"
#include "server/page_loader.h"
#include "server/routes/metrics.h"
#include "server/routes/router.h"
#include "server/server.h"

namespace isosplat::server {

/// Watches the files of stores, scenes and page for changes, in a separate thread.
class FileFollower {
 public:
  /// All must outlive it.
  FileFollower(const ServerOptions& options, Catalog& catalog, StorePool& stores, ScenePool& scenes,
               Router& router, PageLoader& page, ServerLog& log, Metrics& metrics,
               const std::atomic<bool>& stopping)
      : options_(options),
        catalog_(catalog),
        stores_(stores),
        scenes_(scenes),
        router_(router),
        page_(page),
        log_(log),
        metrics_(metrics),
        stopping_(stopping) {}
  ~FileFollower() { join(); }

  /// Starts the thread. Call once.
  void start() {
    thread_ = std::thread([this] { run(); });
  }

  /// Interrupts the wait of the thread. The thread ends if `stopping` is set.
  void wake() { catalog_.wake(); }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run();
  void follow();
  bool examine_scenes();
  bool read_headers(ServedKind kind, std::string& done);

  const ServerOptions& options_;
  Catalog& catalog_;
  StorePool& stores_;
  ScenePool& scenes_;
  Router& router_;
  PageLoader& page_;
  ServerLog& log_;
  Metrics& metrics_;
  const std::atomic<bool>& stopping_;
  std::thread thread_;
};

}  // namespace isosplat::server
