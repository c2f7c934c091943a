#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "server/log/server_log.h"
#include "server/routes/page_assets.h"
#include "server/routes/router.h"

namespace isosplat::server {

/// Gives the router the page below a folder, and again when it has changed. Not thread-safe.
class PageLoader {
 public:
  /// `root`: empty for no page. `max_bytes`: of all files of the page. The router and the log must
  /// outlive the loader.
  PageLoader(std::filesystem::path root, uint64_t max_bytes, Router& router, ServerLog& log);

  /// Loads the page. Errors (io_error): the router keeps the page that it has.
  Result<void> load();

  /// Loads the page again if it has changed since the last load but not since the last call. While
  /// a build writes the page, it is incomplete: the old page is served until the new one is
  /// complete. Logs the result.
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
