#include "server/routes/gzip_response.h"

#include <span>
#include <utility>

#include "server/http/gzip.h"

namespace isosplat::server {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{8} << 20;

/// The ETag of the compressed form.
std::string gzip_etag(const std::string& etag) {
  return etag.substr(0, etag.size() - 1) + "-gzip\"";
}

/// Whether a condition of the request names this ETag. A client that has the uncompressed form
/// continues to use that form.
bool names(const Request& request, const std::string& etag) {
  const auto has = [&](std::string_view field, bool weak) {
    return field != "*" && names_etag(field, etag, weak);
  };
  return has(request.if_none_match, true) || has(request.if_match, false);
}

}  // namespace

std::optional<Response> gzip_response(const RouteCall& call, const std::string& etag,
                                      CachePolicy policy, const CompressibleBody& body) {
  const Request& request = call.request;
  if (body.bytes < Compressor::kMinBytes || body.bytes > kMaxBytes || names(request, etag) ||
      !accepts_encoding(request.accept_encoding, Encoding::gzip)) {
    return {};
  }
  Response response = begin_response(request, gzip_etag(etag), policy, call.is_private);
  response.set("Vary", "Accept-Encoding");
  if (is_complete(response)) return response;
  const auto known = call.compressor.find(body.hash);
  Compressor::Compressed compressed = known.value_or(nullptr);
  if (!known) {
    if (call.no_wait && (body.is_on_disk || body.bytes > Compressor::kLongBytes)) {
      call.no_wait->needs_disk = true;
      return Response{};
    }
    const Result<std::string> bytes = body.read();
    if (bytes) compressed = call.compressor.compress(*bytes, body.hash);
  }
  if (!compressed) return {};
  response.set("Content-Encoding", "gzip");
  response.bytes = std::as_bytes(std::span(*compressed));
  response.owner = compressed;
  return response;
}

}  // namespace isosplat::server
