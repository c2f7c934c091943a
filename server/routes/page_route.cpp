#include "server/routes/page_route.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "server/http/conditions.h"

namespace isosplat::server {
namespace {

/// The page runs only its own scripts, WASM and workers, and fetches stores from any host (?src=…).
/// 'unsafe-inline' is for styles only: components of the page set style attributes. There is no
/// frame-ancestors, so other pages may show it in a frame. The built page states the same policy
/// (vite.config.ts), for hosts that do not send this header; tests/web/page_policy.spec.ts compares
/// them.
constexpr std::string_view kContentSecurityPolicy =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self' blob:; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; manifest-src 'self'; "
    "connect-src 'self' http: https: data: blob:; base-uri 'none'; form-action 'none'";

constexpr std::string_view kNoPage =
    "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Isosplat</title>"
    "<p>This Isosplat server was started without a page (web_root), or it has no index.html. "
    "The volumes are listed at <a href=\"/v1/volumes\">/v1/volumes</a>.</p></html>\n";

/// The first value of a parameter of the page's query; empty if there is none.
std::string_view first_value(const RouteCall& call, std::string_view parameter) {
  for (const auto& [key, value] : call.target.query) {
    if (key == parameter) return value;
  }
  return {};
}

/// Lets the browser fetch the first data of the volume or the scene that the page will show.
void preload_data(Response& response, const RouteCall& call) {
  const std::string_view volume = first_value(call, "volume"), scene = first_value(call, "scene");
  const ServedKind kind = volume.empty() ? ServedKind::scene : ServedKind::volume;
  const CatalogEntry* const entry = call.readable(kind, volume.empty() ? scene : volume);
  if (!entry) return;
  // Names in the catalog need no escaping.
  response.set("Link", fmt::format("<v1/{}s/{}/bootstrap>; rel=preload; as=fetch; "
                                   "crossorigin=anonymous",
                                   word_of(kind), entry->name));
}

/// The smallest variant that the client accepts. Variants are sorted by size.
const AssetVariant& choose_variant(const Asset& asset, std::string_view accept_encoding) {
  return *std::ranges::find_if(asset.variants, [&](const AssetVariant& candidate) {
    return candidate.encoding == Encoding::identity ||
           accepts_encoding(accept_encoding, candidate.encoding);
  });
}

Response asset_response(const RouteCall& call, const Asset& asset) {
  const AssetVariant& variant = choose_variant(asset, call.request.accept_encoding);
  // The HTML response depends on the volumes that the client may read, and may set a cookie.
  const bool is_html = asset.mime_type.starts_with("text/html");
  Response response =
      begin_response(call.request, variant.etag,
                     asset.immutable ? CachePolicy::immutable : CachePolicy::revalidated,
                     is_html && call.is_private);
  response.set("Vary", "Accept-Encoding");
  if (is_html) preload_data(response, call);
  if (is_complete(response)) return response;
  response.set("Content-Type", asset.mime_type);
  if (variant.encoding != Encoding::identity) {
    response.set("Content-Encoding", variant.encoding == Encoding::gzip ? "gzip" : "br");
  }
  response.bytes = std::as_bytes(std::span(variant.bytes));
  response.owner = call.page;
  return response;
}

}  // namespace

Response page_response(const RouteCall& call) {
  const std::string path = call.target.path();
  const Asset* asset = call.page ? call.page->find(path) : nullptr;
  Response response;
  if (asset && asset->immutable && !call.target.query.empty()) {
    // Otherwise caches would keep a copy for each query.
    response =
        error_response(400, status_name(Status::invalid_argument),
                       "expected no parameter: a file with a hash in its name never changes");
  } else if (asset) {
    response = asset_response(call, *asset);
  } else if (path == "/") {
    response.set("Content-Type", "text/html; charset=utf-8");
    response.set("Cache-Control", "no-store");
    response.text = kNoPage;
  } else {
    response = error_response(404, status_name(Status::not_found), "the page has no such file");
  }
  response.set("Content-Security-Policy", kContentSecurityPolicy);
  response.set("Referrer-Policy", "no-referrer");
  return response;
}

}  // namespace isosplat::server
