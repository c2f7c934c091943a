#include "server/routes/json_response.h"

#include <utility>

#include "server/routes/gzip_response.h"

namespace isosplat::server {

Response json_response(const RouteCall& call, std::string text, const std::string& etag,
                       CachePolicy policy) {
  const CompressibleBody body{.bytes = text.size(),
                              .hash = etag_for(text),
                              .read = [&text]() -> Result<std::string> { return text; }};
  Response response;
  if (auto compressed = gzip_response(call, etag, policy, body)) {
    response = std::move(*compressed);
  } else {
    response = begin_response(call.request, etag, policy, call.is_private);
    response.set("Vary", "Accept-Encoding");
    if (!is_complete(response)) response.text = std::move(text);
  }
  if (!is_complete(response)) response.set("Content-Type", "application/json");
  return response;
}

Response json_response(const RouteCall& call, std::string text) {
  const std::string etag = etag_for(text);
  return json_response(call, std::move(text), etag, CachePolicy::revalidated);
}

}  // namespace isosplat::server
