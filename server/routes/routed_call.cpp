#include "server/routes/routed_call.h"

#include <fmt/format.h>

#include <ctime>
#include <string_view>
#include <utility>

#include "server/access/credentials.h"
#include "server/http/query_parameters.h"
#include "server/routes/refusals.h"
#include "server/routes/router.h"

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

/// Whether a target is for the operator of the server. Pages of other origins may not read it.
bool is_for_operators(const Result<Target>& target) {
  return target && target->segments[0] == "metrics";
}

Response not_found(std::string_view message) {
  return error_response(404, status_name(Status::not_found), message);
}

}  // namespace

RoutedCall::RoutedCall(const Router& router, const Request& request, const AdmitClient& admit)
    : router_(router),
      request_(request),
      target_(parse_target(request.target)),
      policy_(is_for_operators(target_) ? router.operator_policy_ : router.policy_),
      now_(static_cast<uint64_t>(std::time(nullptr))) {
  refusal_ = check_request();
  if (!refusal_) refusal_ = find_handler(admit);
}

/// The response to a request that needs no handler, or for which no handler may run, whichever
/// client sends it.
std::optional<Response> RoutedCall::check_request() {
  if (auto refusal = policy_.refuse(request_, has_data())) return refusal;
  if (request_.is_to_redirect) return router_.https_.redirect(request_);
  const size_t most_bytes = router_.limits_.target_bytes;
  if (request_.target.size() > most_bytes) {
    return error_response(
        414, "target_too_long",
        fmt::format("expected a target of at most {} bytes, found {}: send several requests",
                    most_bytes, request_.target.size()));
  }
  if (request_.method == Method::other) {
    Response response = error_response(405, "method_not_allowed", "expected GET, HEAD or OPTIONS");
    response.set("Allow", kMethods);
    return response;
  }
  if (request_.method == Method::options && (target_ || request_.target == "*")) {
    return options_response(has_data());
  }
  if (!target_) return error_response(target_.error());
  return std::nullopt;
}

/// Sets the client's rights, the route and the call; or returns a response without a handler.
std::optional<Response> RoutedCall::find_handler(const AdmitClient& admit) {
  auto [page, access, counts] = router_.current();
  access_ = std::move(access);
  Target& target = *target_;
  if (access_) {
    const CookieOptions cookies = router_.cookies(request_);
    if (!has_data()) {
      if (auto exchange = exchange_token(target, access_, cookies, now_)) return exchange;
    }
    grant_ = AccessRules::grant(access_, credentials_of(request_, target, cookies.name), now_);
    if (auto refusal = take_link(target, access_, now_)) return refusal;
  }
  if (admit) {
    if (auto refusal = admit(grant_.quota_client())) {
      refusal->client = grant_.client();
      return refusal;
    }
  }
  call_.emplace(
      RouteCall{request_,
                target,
                router_.limits_,
                nullptr,
                ThreadKind::computing,
                {router_.catalog_.snapshot(), router_.views_, counts.volumes},
                {router_.catalog_.snapshot(ServedKind::scene), router_.scene_views_, counts.scenes},
                router_.stores_,
                router_.scenes_,
                std::move(page),
                grant_,
                router_.monitor_,
                router_.compressor_,
                router_.chunks_,
                access_ != nullptr,
                {}});
  route_ = find_route(request_.method, target, call_->arguments);
  if (!route_) return not_found("expected a path that server/HTTP.md lists");
  std::optional<Response> refusal = find_entry();
  if (refusal) {
    refusal->route = route_;
    refusal->client = grant_.client();
  }
  return refusal;
}

/// For routes with {name}: finds the volume or the scene. The response for one that the client may
/// not read equals that for one that does not exist.
std::optional<Response> RoutedCall::find_entry() {
  if (call_->arguments.empty()) return std::nullopt;
  entry_ = call_->readable(route_->kind(), call_->arguments[0]);
  if (entry_) return std::nullopt;
  if (!grant_.is_known()) return unauthorized_response();
  const std::string_view word = word_of(route_->kind());
  return not_found(fmt::format("no {0} has this name: /v1/{0}s lists all {0}s", word));
}

/// A response if {content} is another one.
std::optional<Response> RoutedCall::check_content(std::string_view content) const {
  const bool names_content = route_->pattern.find("{content}") != std::string_view::npos;
  if (!names_content || call_->arguments[1] == content) return std::nullopt;
  const std::string_view word = word_of(entry_->kind);
  return not_found(fmt::format("the content of this {0} is now {1}: request /v1/{0}s/{2} again",
                               word, content, entry_->name));
}

/// For routes with {name}: opens its file, and compares its content id with {content}. Returns an
/// error response if the file cannot be served.
std::optional<Response> RoutedCall::open_entry() {
  if (!entry_) return std::nullopt;
  RouteCall& call = *call_;
  const auto refuse = [](const Error& error) {
    if (error.status == Status::out_of_memory) return busy_response(error.message);
    // The pool has logged this error once: do not log it for each request.
    Response response = error_response(error);
    response.status = 500;
    response.fault.clear();
    return response;
  };
  call.is_private = !call.grant.is_public(entry_->name, *entry_);
  if (entry_->kind == ServedKind::scene) {
    auto scene = call.scene_pool.open(*entry_, call.no_wait);
    if (!scene) return refuse(scene.error());
    if (auto other = check_content((*scene)->facts.content)) return other;
    call.scene.emplace(OpenScene{entry_->name, std::move(*scene)});
    return std::nullopt;
  }
  auto store = call.stores.open(*entry_, call.no_wait);
  if (!store) return refuse(store.error());
  if (auto other = check_content((*store)->content())) return other;
  call.volume.emplace(OpenVolume{entry_->name, std::move(*store)});
  return std::nullopt;
}

Response RoutedCall::handle() {
  std::optional<Response> error;
  if (!is_open_) {
    error = open_entry();
    // Check this after access: what the client may not read looks like what does not exist.
    if (!error && !route_->operation.empty()) {
      const Result<void> checked = check_query(*target_, route_->parameters, route_->operation);
      if (!checked) error = error_response(checked.error());
    }
    is_open_ = !error;
  }
  Response response = error ? std::move(*error) : route_->handler(*call_);
  response.route = route_;
  response.client = grant_.client();
  if (!error && access_ && !has_data()) {
    set_link_cookie(*target_, access_, router_.cookies(request_), now_, response);
  }
  return response;
}

Response RoutedCall::respond(ThreadKind thread, NoWait* no_wait, WorkTurn* turn) {
  Response response;
  if (refusal_) {
    response = std::move(*refusal_);
  } else {
    call_->thread = thread;
    call_->no_wait = no_wait;
    call_->turn = turn;
    response = handle();
  }
  response.set("X-Content-Type-Options", "nosniff");
  router_.https_.add_fields(request_, response);
  if (has_data()) {
    policy_.add_fields(request_, response);
  } else {
    policy_.add_page_fields(request_, response);
  }
  return response;
}

}  // namespace isosplat::server
