#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "server/access/access_rules.h"
#include "server/access/credentials.h"
#include "server/access/https.h"
#include "server/access/origin_policy.h"
#include "server/catalog/catalog.h"
#include "server/catalog/chunk_cache.h"
#include "server/catalog/scene_pool.h"
#include "server/catalog/store_pool.h"
#include "server/http/gzip.h"
#include "server/http/message.h"
#include "server/routes/page_assets.h"
#include "server/routes/route_call.h"
#include "server/routes/routed_call.h"

namespace isosplat::server {

/// Computes the responses to requests; HTTP.md lists the routes. Independent of sockets.
/// Thread-safe.
class Router {
 public:
  /// All must outlive the router.
  Router(const Catalog& catalog, StorePool& stores, ScenePool& scenes, RouterLimits limits);

  /// Sets the hosts and pages that are allowed. Not thread-safe: call before route().
  void set_policy(OriginPolicy policy) {
    operator_policy_ = policy.for_own_pages();
    policy_ = std::move(policy);
  }
  const OriginPolicy& policy() const { return policy_; }

  /// Sets the name of the cookies. Not thread-safe, as above.
  void set_cookie_name(std::string name) { cookie_name_ = std::move(name); }

  /// Sets the redirections and fields that make clients use TLS. Not thread-safe, as above.
  void set_https(HttpsPolicy https) { https_ = https; }

  /// Sets the data that the routes for operators report. Not thread-safe, as above.
  void set_monitor(Monitor monitor) { monitor_ = monitor; }

  /// Sets the access rules for the following requests; null: every client may read every volume.
  void set_access(std::shared_ptr<const AccessRules> access);

  /// Sets the page for the following requests; null: no page.
  void set_page(std::shared_ptr<const PageAssets> page);

  /// Counts the volumes and scenes for /healthz, /readyz and /metrics, and lists those that every
  /// client may read, if these have changed. The time of such requests then does not grow with the
  /// number of files. Call it regularly, from one thread at a time.
  void count_files();

  /// Routes a request, which must outlive the call. Needs no disk. `admit` is called once, unless
  /// the response does not depend on the client.
  RoutedCall route(const Request& request, const AdmitClient& admit = {}) const {
    return RoutedCall(*this, request, admit);
  }

  /// Routes the request and runs its handler, in one call.
  Response respond(const Request& request) const { return route(request).respond(); }

 private:
  friend class RoutedCall;

  struct Counts {
    VolumeCounts volumes, scenes;
  };
  struct Current {
    std::shared_ptr<const PageAssets> page;
    std::shared_ptr<const AccessRules> access;
    Counts counts;
  };

  /// The files of one kind that were counted last, and the access rules and news of that time.
  struct Counted {
    std::shared_ptr<const AccessRules> access;
    std::shared_ptr<const CatalogSnapshot> catalog;
    uint64_t news = 0;
    VolumeCounts counts;
  };
  void count(ServedKind kind, uint64_t news, VolumeViews& views, Counted& counted);
  Current current() const;
  CookieOptions cookies(const Request& request) const { return {cookie_name_, request.has_tls}; }

  const Catalog& catalog_;
  StorePool& stores_;
  ScenePool& scenes_;
  const RouterLimits limits_;
  OriginPolicy policy_;
  std::string cookie_name_;
  OriginPolicy operator_policy_;  ///< for /metrics
  HttpsPolicy https_;
  Monitor monitor_;
  mutable Compressor compressor_;
  static constexpr uint64_t kKeptChunkBytes = uint64_t{32} << 20;
  mutable ChunkCache chunks_{kKeptChunkBytes};
  mutable VolumeViews views_;
  mutable VolumeViews scene_views_;

  // Of count_files().
  Counted counted_volumes_;
  Counted counted_scenes_;

  mutable std::mutex mutex_;
  std::shared_ptr<const PageAssets> page_;     // guarded by mutex_
  std::shared_ptr<const AccessRules> access_;  // guarded by mutex_
  Counts counts_;                              // guarded by mutex_
};

}  // namespace isosplat::server
