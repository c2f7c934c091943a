#pragma once

#include <memory>
#include <mutex>
#include <utility>

#include "server/catalog.h"
#include "server/message.h"
#include "server/origin_policy.h"
#include "server/page_assets.h"
#include "server/routes.h"

namespace isosplat {

/// Makes the responses to requests; HTTP.md lists the routes. Independent of sockets. Thread-safe.
/// Reads files, so a call may wait for the disk.
class Router {
 public:
  Router(const Catalog& catalog, RouterLimits limits);

  /// Sets the hosts and pages that are allowed. Not thread-safe: call before respond().
  void set_policy(OriginPolicy policy) { policy_ = std::move(policy); }
  const OriginPolicy& policy() const { return policy_; }

  /// Sets the page for the following requests; null: no page.
  void set_page(std::shared_ptr<const PageAssets> page);

  Response respond(const Request& request) const;

 private:
  Response route(const Request& request, const Target& target) const;
  std::shared_ptr<const PageAssets> page() const;

  const Catalog& catalog_;
  const RouterLimits limits_;
  OriginPolicy policy_;
  mutable std::mutex page_mutex_;
  std::shared_ptr<const PageAssets> page_;  // guarded by page_mutex_
};

}  // namespace isosplat
