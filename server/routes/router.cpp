#include "server/routes/router.h"

#include <fmt/format.h>

#include <ctime>
#include <optional>
#include <utility>

#include "server/routes/refusals.h"

namespace isosplat::server {
namespace {

constexpr std::string_view kMethods = "GET, HEAD, OPTIONS";

Response options_response(bool is_data) {
  Response response;
  response.status = 204;
  response.set("Allow", kMethods);
  if (is_data) {
    response.set("Access-Control-Allow-Methods", kMethods);
    response.set("Access-Control-Allow-Headers",
                 "Authorization, If-Match, If-None-Match, If-Range, Range");
    response.set("Access-Control-Max-Age", "86400");
  }
  return response;
}

/// Whether a target is for the operator of the server, and for no page of another origin.
bool is_for_operators(const Result<Target>& target) {
  return target && target->segments[0] == "metrics";
}

Response not_found(std::string_view message) {
  return error_response(404, status_name(Status::not_found), message);
}

/// For routes with {name}: looks the volume up, and compares its content id with {content}. Returns
/// an error response if there is no such volume, or no store that can be served. A volume that the
/// client may not read is answered exactly as one that does not exist.
std::optional<Response> find_volume(const Route& route, RouteCall& call) {
  if (call.arguments.empty()) return std::nullopt;
  const CatalogEntry* const found = call.readable(call.arguments[0]);
  if (!found) {
    if (!call.grant.is_known()) return unauthorized_response();
    return not_found("no volume has this name: /v1/volumes lists all volumes");
  }
  const CatalogEntry& entry = *found;
  auto store = call.stores.open(entry, call.no_wait);
  if (!store) {
    if (store.error().status == Status::out_of_memory) return busy_response(store.error().message);
    // The pool has logged this error once: do not log it for each request.
    Response response = error_response(store.error());
    response.status = 500;
    response.fault.clear();
    return response;
  }
  const bool names_content = route.pattern.find("{content}") != std::string_view::npos;
  if (names_content && call.arguments[1] != (*store)->content()) {
    return not_found(
        fmt::format("the content of this volume is now {}: request /v1/volumes/{} "
                    "again",
                    (*store)->content(), entry.name));
  }
  call.volume.emplace(OpenVolume{entry.name, std::move(*store)});
  call.is_private = !call.grant.is_public(entry.name, entry);
  return std::nullopt;
}

}  // namespace

Router::Router(const Catalog& catalog, StorePool& stores, RouterLimits limits)
    : catalog_(catalog), stores_(stores), limits_(limits) {}

void Router::set_page(std::shared_ptr<const PageAssets> page) {
  const std::lock_guard lock(mutex_);
  page_ = std::move(page);
}

void Router::set_access(std::shared_ptr<const AccessRules> access) {
  if (access && access->is_open()) access.reset();
  const std::lock_guard lock(mutex_);
  access_ = std::move(access);
}

Router::Current Router::current() const {
  const std::lock_guard lock(mutex_);
  return {page_, access_, counts_};
}

void Router::count_volumes() {
  const auto access = current().access;
  const auto catalog = catalog_.snapshot();
  const uint64_t news = stores_.news();
  if (access == counted_access_ && catalog == counted_catalog_ && news == counted_news_) return;
  VolumeCounts counts;
  const auto is_broken = [](const CatalogEntry& entry) {
    return entry.summary.state() == StoreState::broken;
  };
  const auto open_to_all = views_.make(catalog, AccessRules::grant(access, {}, 0));
  counts.open_to_all = open_to_all->entries.size();
  for (const CatalogEntry* entry : open_to_all->entries) {
    if (is_broken(*entry)) ++counts.open_to_all_broken;
  }
  for (const auto& [name, entry] : *catalog) {
    const StoreState state = entry->summary.state();
    ++(state == StoreState::served   ? counts.served
       : state == StoreState::broken ? counts.broken
                                     : counts.unread);
  }
  counted_access_ = access;
  counted_catalog_ = catalog;
  counted_news_ = news;
  const std::lock_guard lock(mutex_);
  counts_ = counts;
}

Response Router::respond(const Request& request, NoWait* no_wait, ThreadKind thread, WorkTurn* turn,
                         const AdmitClient& admit) const {
  Response response;
  Result<Target> target = parse_target(request.target);
  const bool is_page = target && !is_data(*target);
  const OriginPolicy& policy = is_for_operators(target) ? operator_policy_ : policy_;
  if (std::optional<Response> refusal = policy.refuse(request, !is_page)) {
    response = std::move(*refusal);
  } else if (request.is_to_redirect) {
    response = https_.redirect(request);
  } else if (request.target.size() > limits_.target_bytes) {
    response = error_response(
        414, "target_too_long",
        fmt::format("expected a target of at most {} bytes, found {}: send several requests",
                    limits_.target_bytes, request.target.size()));
  } else if (request.method == Method::other) {
    response = error_response(405, "method_not_allowed", "expected GET, HEAD or OPTIONS");
    response.set("Allow", kMethods);
  } else if (request.method == Method::options && (target || request.target == "*")) {
    response = options_response(!is_page);
  } else if (!target) {
    response = error_response(target.error());
  } else {
    response = route(request, *target, no_wait, thread, turn, admit);
  }
  response.set("X-Content-Type-Options", "nosniff");
  https_.add_fields(request, response);
  if (is_page) {
    policy.add_page_fields(request, response);
  } else {
    policy.add_fields(request, response);
  }
  return response;
}

Response Router::route(const Request& request, Target& target, NoWait* no_wait, ThreadKind thread,
                       WorkTurn* turn, const AdmitClient& admit) const {
  auto [page, access, counts] = current();
  const bool is_for_page = !is_data(target);
  Grant grant;
  const auto now = static_cast<uint64_t>(std::time(nullptr));
  const CookieOptions cookies{cookie_name_, request.has_tls};
  if (access) {
    if (is_for_page) {
      if (auto exchange = exchange_token(target, access, cookies, now)) return std::move(*exchange);
    }
    grant = AccessRules::grant(access, credentials_of(request, target, cookies.name), now);
    if (auto refusal = take_link(target, access, now)) return std::move(*refusal);
  }
  if (admit) {
    if (auto refusal = admit(grant.quota_client())) {
      refusal->client = grant.client();
      return std::move(*refusal);
    }
  }
  RouteCall call{request,  target,          limits_,
                 no_wait,  thread,          catalog_.snapshot(),
                 stores_,  std::move(page), grant,
                 monitor_, compressor_,     chunks_,
                 views_,   counts,          access != nullptr,
                 {}};
  call.turn = turn;
  const Route* const route = find_route(request.method, target, call.arguments);
  if (!route) return not_found("expected a path that server/HTTP.md lists");
  std::optional<Response> error = find_volume(*route, call);
  // Behind access: a volume that the client may not read is answered as one that does not exist.
  if (!error && !route->operation.empty()) {
    const Result<void> checked = check_query(target, route->parameters, route->operation);
    if (!checked) error = error_response(checked.error());
  }
  Response response = error ? std::move(*error) : route->handler(call);
  response.route = route;
  response.client = grant.client();
  if (error) return response;
  if (access && is_for_page) set_link_cookie(target, access, cookies, now, response);
  return response;
}

}  // namespace isosplat::server
