#include "server/router.h"

#include <span>
#include <utility>

#include "server/conditions.h"
#include "server/content_routes.h"
#include "server/streams.h"
#include "server/volume_json.h"

namespace isosplat {
namespace {

constexpr std::string_view kMethods = "GET, HEAD, OPTIONS";

/// The page runs its own scripts, WASM and workers, and fetches stores from any host (?src=…). The
/// components of the page set style attributes, hence 'unsafe-inline' for styles only.
constexpr std::string_view kContentSecurityPolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
    "connect-src * data: blob:; object-src 'none'; base-uri 'none'; form-action 'none'";

constexpr std::string_view kNoPage =
    "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Isosplat</title>"
    "<p>This Isosplat server was started without a page (web_root), or it has no index.html. "
    "The volumes are listed at <a href=\"/v1/volumes\">/v1/volumes</a>.</p></html>\n";

void add_data_fields(Response& response) {
  response.set("Access-Control-Allow-Origin", "*");
  response.set("Access-Control-Expose-Headers",
               "Accept-Ranges, Content-Length, Content-Range, ETag, Retry-After, "
               "X-Isosplat-Chunks");
  response.set("Cross-Origin-Resource-Policy", "cross-origin");
  response.set("Timing-Allow-Origin", "*");
}

Response options_answer(bool is_data) {
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

/// An answer that may change at any time, without its body: revalidated on each use. Its status is
/// 304 where the client has it already.
Response changing(const Request& request, const std::string& etag) {
  Response response;
  response.set("ETag", etag);
  response.set("Cache-Control", "no-cache");
  if (!request.if_none_match.empty() && names_etag(request.if_none_match, etag, /*weak=*/true)) {
    response.status = 304;
  }
  return response;
}

Response changing_json(const Request& request, std::string text) {
  Response response = changing(request, etag_for(text));
  if (response.status == 304) return response;
  response.set("Content-Type", "application/json");
  response.text = std::move(text);
  return response;
}

/// What a viewer needs for its first picture, in one answer.
Response opening_answer(const Request& request, std::shared_ptr<const StoreFile> store) {
  if (Result<void> unchanged = store->check_unchanged(); !unchanged) {
    return error_response(unchanged.error());
  }
  Response response = changing(request, "\"" + store->content() + "-opening1\"");
  if (response.status == 304) return response;
  response.set("Content-Type", "application/octet-stream");
  response.stream = std::make_unique<OpeningStream>(std::move(store));
  return response;
}

Response health(const CatalogSnapshot& snapshot) {
  size_t served = 0;
  for (const auto& [name, entry] : snapshot) served += entry.store ? 1 : 0;
  Response response;
  response.set("Content-Type", "application/json");
  response.set("Cache-Control", "no-store");
  response.text = "{\"status\":\"ok\",\"volumes\":" + std::to_string(served) +
                  ",\"broken\":" + std::to_string(snapshot.size() - served) + "}\n";
  return response;
}

}  // namespace

Router::Router(const Catalog& catalog, RouterLimits limits) : catalog_(catalog), limits_(limits) {}

void Router::set_page(std::shared_ptr<const PageAssets> page) {
  const std::lock_guard lock(page_mutex_);
  page_ = std::move(page);
}

Response Router::answer(const Request& request) const {
  Response response;
  const Result<Target> target = parse_target(request.target);
  const bool is_page = target && target->segments[0] != "v1" && target->segments[0] != "healthz";
  if (request.target.size() > limits_.target_bytes) {
    response = error_response(
        414, "target_too_long",
        "expected a target of at most " + std::to_string(limits_.target_bytes) + " bytes, found " +
            std::to_string(request.target.size()) + ": ask in several requests");
  } else if (request.method == Method::other) {
    response = error_response(405, "method_not_allowed", "expected GET, HEAD or OPTIONS");
    response.set("Allow", kMethods);
  } else if (request.method == Method::options && (target || request.target == "*")) {
    response = options_answer(!is_page);
  } else if (!target) {
    response = error_response(target.error());
  } else {
    response = is_page ? page_asset(request, *target) : route(request, *target);
  }
  response.set("X-Content-Type-Options", "nosniff");
  if (!is_page) add_data_fields(response);
  return response;
}

Response Router::route(const Request& request, const Target& target) const {
  const std::vector<std::string>& segments = target.segments;
  if (segments[0] == "healthz" && segments.size() == 1) return health(*catalog_.snapshot());
  if (segments[0] == "v1" && segments.size() >= 2 && segments[1] == "volumes") {
    if (segments.size() == 2) return volumes(request);
    return volume(request, target);
  }
  return error_response(404, status_name(Status::not_found),
                        "expected /healthz, or a path below /v1/volumes");
}

Response Router::volumes(const Request& request) const {
  return changing_json(request, volume_list_json(*catalog_.snapshot()));
}

Response Router::volume(const Request& request, const Target& target) const {
  const std::shared_ptr<const CatalogSnapshot> snapshot = catalog_.snapshot();
  const auto found = snapshot->find(target.segments[2]);
  if (found == snapshot->end()) {
    return error_response(404, status_name(Status::not_found),
                          "no volume of this name: /v1/volumes lists those there are");
  }
  const CatalogEntry& entry = found->second;
  if (!entry.store) {
    // Known to whoever runs the server from the log, once: not a fault of each request.
    Response response = error_response(*entry.error);
    response.status = 500;
    response.fault.clear();
    return response;
  }
  if (target.segments.size() == 3) return changing_json(request, volume_json(entry));
  if (target.segments.size() == 4 && target.segments[3] == "opening") {
    return opening_answer(request, entry.store);
  }
  if (target.segments[3] != entry.store->content()) {
    return error_response(404, status_name(Status::not_found),
                          "this volume's content is now " + entry.store->content() +
                              ": ask /v1/volumes/" + entry.name + " anew");
  }
  return content_answer(request, entry.store, std::span(target.segments).subspan(4), target,
                        limits_);
}

/// The browser asks for the volume's first bytes as soon as it has these fields: beside what the
/// page is made of, not after it.
void Router::preload_volume(Response& response, const Target& target) const {
  for (const auto& [key, value] : target.query) {
    if (key != "volume") continue;
    const std::shared_ptr<const CatalogSnapshot> snapshot = catalog_.snapshot();
    const auto found = snapshot->find(value);
    if (found == snapshot->end() || !found->second.store) return;
    // The catalog's name, of characters that need no escape.
    response.set("Link", "<v1/volumes/" + found->first +
                             "/opening>; rel=preload; as=fetch; crossorigin=anonymous");
    return;
  }
}

Response Router::page_asset(const Request& request, const Target& target) const {
  std::shared_ptr<const PageAssets> page;
  {
    const std::lock_guard lock(page_mutex_);
    page = page_;
  }
  const std::string path = target.path();
  const Asset* asset = page ? page->find(path) : nullptr;
  Response response;
  if (asset == nullptr && path != "/") {
    response = error_response(404, status_name(Status::not_found), "the page has no such file");
  } else if (asset == nullptr) {
    response.set("Content-Type", "text/html; charset=utf-8");
    response.set("Cache-Control", "no-store");
    response.text = kNoPage;
  } else {
    // Ascending in size: the first that the client takes is the smallest it can have.
    const AssetVariant* variant = nullptr;
    for (const AssetVariant& candidate : asset->variants) {
      if (candidate.encoding == Encoding::identity ||
          accepts_encoding(request.accept_encoding, candidate.encoding)) {
        variant = &candidate;
        break;
      }
    }
    response.set("ETag", variant->etag);
    response.set("Cache-Control",
                 asset->immutable ? "public, max-age=31536000, immutable" : "no-cache");
    response.set("Vary", "Accept-Encoding");
    if (asset->mime_type.starts_with("text/html")) preload_volume(response, target);
    if (!request.if_none_match.empty() &&
        names_etag(request.if_none_match, variant->etag, /*weak=*/true)) {
      response.status = 304;
    } else {
      response.set("Content-Type", asset->mime_type);
      if (variant->encoding != Encoding::identity) {
        response.set("Content-Encoding", variant->encoding == Encoding::gzip ? "gzip" : "br");
      }
      response.bytes = std::as_bytes(std::span(variant->bytes));
      response.owner = page;
    }
  }
  response.set("Content-Security-Policy", kContentSecurityPolicy);
  response.set("Referrer-Policy", "no-referrer");
  return response;
}

}  // namespace isosplat
