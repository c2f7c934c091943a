#include "server/routes/json_response.h"

#include <span>
#include <utility>

#include "server/http/gzip.h"

namespace isosplat::server {
namespace {

/// The ETag of the compressed form.
std::string gzip_etag(const std::string& etag) {
  return etag.substr(0, etag.size() - 1) + "-gzip\"";
}

/// Whether a condition of the request names this ETag. A client that has the uncompressed text
/// continues to use that form.
bool names(const Request& request, const std::string& etag) {
  const auto has = [&](std::string_view field, bool weak) {
    return field != "*" && names_etag(field, etag, weak);
  };
  return has(request.if_none_match, true) || has(request.if_match, false);
}

}  // namespace

Response json_response(const RouteCall& call, std::string text, const std::string& etag,
                       CachePolicy policy) {
  const Request& request = call.request;
  const bool is_compressed = text.size() >= TextCompressor::kMinBytes &&
                             accepts_encoding(request.accept_encoding, Encoding::gzip) &&
                             !names(request, etag);
  Response response =
      begin_response(request, is_compressed ? gzip_etag(etag) : etag, policy, call.is_private);
  if (is_compressed && !is_complete(response)) {
    const std::string hash = etag_for(text);
    if (call.no_wait && call.compressor.is_slow(text, hash)) {
      call.no_wait->needs_disk = true;
      return {};
    }
    if (const auto compressed = call.compressor.compress(text, hash)) {
      response.set("Content-Encoding", "gzip");
      response.bytes = std::as_bytes(std::span(*compressed));
      response.owner = compressed;
    } else {
      response = begin_response(request, etag, policy, call.is_private);
    }
  }
  response.set("Vary", "Accept-Encoding");
  if (is_complete(response)) return response;
  response.set("Content-Type", "application/json");
  if (!response.owner) response.text = std::move(text);
  return response;
}

Response json_response(const RouteCall& call, std::string text) {
  const std::string etag = etag_for(text);
  return json_response(call, std::move(text), etag, CachePolicy::revalidated);
}

}  // namespace isosplat::server
