#pragma once

#include <string>

#include "server/http/conditions.h"
#include "server/http/message.h"
#include "server/routes/route_call.h"

namespace isosplat::server {

/// A JSON response for a resource with this ETag. Evaluates conditions as in begin_response(), and
/// compresses the text for clients that admit gzip. The compressed form has a separate ETag, since
/// its bytes differ. A long text is compressed on a thread that may wait (NoWait::needs_disk).
Response json_response(const RouteCall& call, std::string text, const std::string& etag,
                       CachePolicy policy);

/// The same, revalidated, with a hash of the text as ETag.
Response json_response(const RouteCall& call, std::string text);

}  // namespace isosplat::server
