#include "server/routes/compressible_response.h"

#include <span>

namespace isosplat::server {
namespace {

constexpr uint64_t kMaxBytesOnDisk = uint64_t{8} << 20;

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

/// Whether this form of the body can be sent to the client.
bool may_compress(const Request& request, const std::string& etag, const CompressibleBody& body) {
  return body.bytes >= Compressor::kMinBytes &&
         (!body.is_on_disk || body.bytes <= kMaxBytesOnDisk) &&
         accepts_encoding(request.accept_encoding, Encoding::gzip) && !names(request, etag);
}

/// Begins the response of one form of the body.
Response begin_form(const RouteCall& call, const std::string& etag, CachePolicy policy,
                    const CompressibleBody& body) {
  Response response = begin_response(call.request, etag, policy, call.is_private);
  response.set("Vary", "Accept-Encoding");
  if (!is_complete(response)) response.set("Content-Type", body.type);
  return response;
}

}  // namespace

Response compressible_response(const RouteCall& call, const std::string& etag, CachePolicy policy,
                               const CompressibleBody& body) {
  if (may_compress(call.request, etag, body)) {
    Response response = begin_form(call, gzip_etag(etag), policy, body);
    if (is_complete(response)) return response;
    const std::string hash = body.hash();
    const auto known = call.compressor.find(hash);
    if (!known && call.no_wait && (body.is_on_disk || body.bytes > Compressor::kLongBytes)) {
      call.no_wait->needs_disk = true;
      return {};
    }
    if (const Compressor::Compressed compressed = known ? *known : body.compress(hash)) {
      response.set("Content-Encoding", "gzip");
      response.bytes = std::as_bytes(std::span(*compressed));
      response.owner = compressed;
      return response;
    }
  }
  Response response = begin_form(call, etag, policy, body);
  if (!is_complete(response)) body.send(response);
  return response;
}

}  // namespace isosplat::server
