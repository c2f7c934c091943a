#pragma once

#include <string>

#include "server/http/conditions.h"
#include "server/http/message.h"
#include "server/routes/route_call.h"

namespace isosplat::server {

/// The response with this text of JSON, for a resource with this ETag: conditions are evaluated as
/// in begin_response(), and the text is compressed for clients that admit gzip. The compressed form
/// has an ETag of its own, since it has other bytes. A long text is compressed on a thread that may
/// wait (NoWait::needs_disk).
Response json_response(const RouteCall& call, std::string text, const std::string& etag,
                       CachePolicy policy);

/// The same with an ETag of the text, revalidated.
Response json_response(const RouteCall& call, std::string text);

}  // namespace isosplat::server
