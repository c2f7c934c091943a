#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "server/http/conditions.h"
#include "server/routes/route_call.h"

namespace isosplat::server {

/// A body that may be sent compressed.
struct CompressibleBody {
  uint64_t bytes = 0;
  std::string hash;         ///< identifies the bytes, for example an ETag
  bool is_on_disk = false;  ///< read() waits for the disk
  std::function<Result<std::string>()> read;
};

/// The response with this body as gzip, without Content-Type. Null if the body must be sent as it
/// is: the client does not admit gzip or has the uncompressed form, the body is short or longer
/// than 8 MiB, it cannot be read, or others are being compressed. If compression would keep a
/// connection's thread from other connections, sets call.no_wait->needs_disk. In both forms, the
/// response needs `Vary: Accept-Encoding`; this one has it. `etag`: of the uncompressed form.
std::optional<Response> gzip_response(const RouteCall& call, const std::string& etag,
                                      CachePolicy policy, const CompressibleBody& body);

}  // namespace isosplat::server
