#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/access/access_rules.h"
#include "server/access/origin_policy.h"
#include "server/catalog/catalog.h"
#include "server/http/message.h"
#include "server/http/target.h"
#include "server/routes/route_call.h"
#include "server/routes/routes.h"

namespace isosplat::server {

class Router;

/// Called once the client is known (Grant::quota_client), before any work for the request. Returns
/// a response if the client must wait.
using AdmitClient = std::function<std::optional<Response>(const std::string& client)>;

/// A routed request: its target is parsed, the policies and the access rules have admitted it, and
/// its handler is found; or it was refused. respond() runs only the handler, and is called more
/// than once for a request that waits for a disk or computes. The router and the request must
/// outlive the call. For one thread at a time.
class RoutedCall {
 public:
  RoutedCall(const RoutedCall&) = delete;
  RoutedCall& operator=(const RoutedCall&) = delete;

  /// Null if the request was refused before it had a route.
  const Route* route() const { return route_; }

  /// Runs the handler on a thread of this kind. If it sets no_wait->needs_disk, discard the result
  /// and call again without `no_wait`, on a thread that may wait for the disk; for a route that
  /// computes, see RouteWork. If it sets turn->is_unfinished, discard the result and call again
  /// with this turn, after other work.
  Response respond(ThreadKind thread = ThreadKind::computing, NoWait* no_wait = nullptr,
                   WorkTurn* turn = nullptr);

 private:
  friend class Router;
  RoutedCall(const Router& router, const Request& request, const AdmitClient& admit);

  std::optional<Response> check_request();
  std::optional<Response> find_handler(const AdmitClient& admit);
  std::optional<Response> find_entry();
  std::optional<Response> open_entry();
  std::optional<Response> check_content(std::string_view content) const;
  Response handle();
  bool has_data() const { return !target_ || is_data(*target_); }

  const Router& router_;
  const Request& request_;
  Result<Target> target_;
  const OriginPolicy& policy_;
  const uint64_t now_;  ///< seconds since 1970
  std::shared_ptr<const AccessRules> access_;
  Grant grant_;
  std::optional<Response> refusal_;      ///< the response, without a handler
  const Route* route_ = nullptr;         ///< null only with a refusal
  const CatalogEntry* entry_ = nullptr;  ///< of routes with {name}; in the call's catalog
  bool is_open_ = false;                 ///< whether its file is opened and the query checked
  std::optional<RouteCall> call_;        ///< absent only with a refusal
};

}  // namespace isosplat::server
