#include "server/routes/json_response.h"

#include <utility>

#include "server/routes/compressible_response.h"

namespace isosplat::server {

Response json_response(const RouteCall& call, std::string text, const std::string& etag,
                       CachePolicy policy) {
  return compressible_response(
      call, etag, policy,
      {.type = "application/json",
       .bytes = text.size(),
       .hash = [&] { return etag_for(text); },
       .compress = [&](const std::string& hash) { return call.compressor.compress(text, hash); },
       .send = [&](Response& response) { response.text = std::move(text); }});
}

Response json_response(const RouteCall& call, std::string text) {
  const std::string etag = etag_for(text);
  return json_response(call, std::move(text), etag, CachePolicy::revalidated);
}

}  // namespace isosplat::server
