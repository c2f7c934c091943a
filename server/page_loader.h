#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/log/server_log.h"
#include "server/routes/page_assets.h"
#include "server/routes/router.h"

namespace isosplat::server {

/// Loads the page from a folder into the router, and reloads it when files have changed. Not
/// thread-safe.
class PageLoader {
 public:
  /// `root`: empty for no page. `max_bytes`: of all files of the page. The router and the log must
  /// outlive the loader.
  PageLoader(std::filesystem::path root, uint64_t max_bytes, Router& router, ServerLog& log);

  /// Loads the page. If this fails (io_error), the router keeps the present page.
  Result<void> load();

  /// Reloads the page if files have changed since the last load, and none has changed since the
  /// last call. The page is incomplete while a build writes it: the old page is served until the
  /// new one is complete. Logs the result.
  void load_if_changed();

 private:
  const std::filesystem::path root_;
  const uint64_t max_bytes_;
  Router& router_;
  ServerLog& log_;
  std::shared_ptr<const PageAssets> page_;  ///< null: none yet
  uint64_t signature_ = 0;                  ///< of the last attempt to load the page
  uint64_t seen_ = 0;                       ///< of the last call of load_if_changed()
};

}  // namespace isosplat::server
