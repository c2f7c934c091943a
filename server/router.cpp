#include "server/router.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

namespace isosplat {
namespace {

constexpr std::string_view kMethods = "GET, HEAD, OPTIONS";

Response options_response(bool is_data) {
  Response response;
  response.status = 204;
  response.set("Allow", kMethods);
  if (is_data) {
    response.set("Access-Control-Allow-Methods", kMethods);
    response.set("Access-Control-Allow-Headers", "If-Match, If-None-Match, If-Range, Range");
    response.set("Access-Control-Max-Age", "86400");
  }
  return response;
}

/// Whether a target belongs to the data interface; all other targets belong to the page.
bool is_data(const Target& target) {
  return target.segments[0] == "v1" || target.segments[0] == "healthz";
}

Response not_found(std::string_view message) {
  return error_response(404, status_name(Status::not_found), message);
}

/// For routes with {name}: looks the volume up, and compares its content id with {content}. Returns
/// an error response if there is no such volume, or no store that can be served.
std::optional<Response> find_volume(const Route& route, RouteCall& call) {
  if (call.arguments.empty()) return std::nullopt;
  const auto found = call.catalog->find(call.arguments[0]);
  if (found == call.catalog->end()) {
    return not_found("no volume has this name: /v1/volumes lists all volumes");
  }
  const CatalogEntry& entry = found->second;
  if (!entry.store) {
    // The catalog has logged this error once: do not log it for each request.
    Response response = error_response(*entry.error);
    response.status = 500;
    response.fault.clear();
    return response;
  }
  const bool names_content = route.pattern.find("{content}") != std::string_view::npos;
  if (names_content && call.arguments[1] != entry.store->content()) {
    return not_found(
        fmt::format("the content of this volume is now {}: request /v1/volumes/{} "
                    "again",
                    entry.store->content(), entry.name));
  }
  call.volume = &entry;
  return std::nullopt;
}

}  // namespace

Router::Router(const Catalog& catalog, RouterLimits limits) : catalog_(catalog), limits_(limits) {}

void Router::set_page(std::shared_ptr<const PageAssets> page) {
  const std::lock_guard lock(page_mutex_);
  page_ = std::move(page);
}

std::shared_ptr<const PageAssets> Router::page() const {
  const std::lock_guard lock(page_mutex_);
  return page_;
}

Response Router::respond(const Request& request) const {
  Response response;
  const Result<Target> target = parse_target(request.target);
  const bool is_page = target && !is_data(*target);
  if (std::optional<Response> refusal = policy_.refuse(request, !is_page)) {
    response = std::move(*refusal);
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
    response = route(request, *target);
  }
  response.set("X-Content-Type-Options", "nosniff");
  if (!is_page) policy_.add_fields(request, response);
  return response;
}

Response Router::route(const Request& request, const Target& target) const {
  RouteCall call{request, target, limits_, catalog_.snapshot(), page(), {}};
  const Route* const route = find_route(request.method, target, call.arguments);
  if (!route) return not_found("expected a path that server/HTTP.md lists");
  if (std::optional<Response> error = find_volume(*route, call)) return std::move(*error);
  return route->handler(call);
}

}  // namespace isosplat
