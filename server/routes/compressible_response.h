#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "server/http/conditions.h"
#include "server/http/gzip.h"
#include "server/routes/route_call.h"

namespace isosplat::server {

/// A body that is compressed for clients that admit gzip.
struct CompressibleBody {
  std::string_view type;  ///< Content-Type
  uint64_t bytes = 0;
  /// compress() waits for the disk. Bodies on disk of more than 8 MiB are sent uncompressed.
  bool is_on_disk = false;
  /// Identifies the bytes among all bodies of the server.
  std::function<std::string()> hash;
  /// Compressor::compress of the bytes; null also if they cannot be read.
  std::function<Compressor::Compressed(const std::string& hash)> compress;
  /// Sets the uncompressed body of a response.
  std::function<void(Response&)> send;
};

/// A response with this body, or one of begin_response() that is complete without it. The
/// compressed form has a separate ETag, since its bytes differ. If compression would keep a
/// connection's thread from other connections, sets call.no_wait->needs_disk. `etag`: of the
/// uncompressed form.
Response compressible_response(const RouteCall& call, const std::string& etag, CachePolicy policy,
                               const CompressibleBody& body);

}  // namespace isosplat::server
