#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string_view>

#include "server/catalog.h"
#include "server/message.h"
#include "server/page_assets.h"
#include "server/target.h"

namespace isosplat {

struct RouterLimits {
  uint64_t query_bytes = uint64_t{64} << 20;
  uint32_t query_chunks = 65536;
  uint64_t query_directory_bytes = uint64_t{256} << 20;
  size_t target_bytes = 8 * 1024;
};

/// Answers requests, whatever carried them: HTTP.md lists the routes. Callable from any thread at a
/// time. Reads files, so an answer may wait for the disk.
class Router {
 public:
  Router(const Catalog& catalog, RouterLimits limits);

  /// The page, from now on; null: none.
  void set_page(std::shared_ptr<const PageAssets> page);

  Response answer(const Request& request) const;

 private:
  Response route(const Request& request, const Target& target) const;
  Response page_asset(const Request& request, const Target& target) const;
  void preload_volume(Response& response, const Target& target) const;
  Response volumes(const Request& request) const;
  Response volume(const Request& request, const Target& target) const;

  const Catalog& catalog_;
  const RouterLimits limits_;
  mutable std::mutex page_mutex_;
  std::shared_ptr<const PageAssets> page_;  // guarded by page_mutex_
};

}  // namespace isosplat
