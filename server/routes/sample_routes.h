#pragma once

#include "server/routes/route_call.h"

namespace isosplat::server {

// Handlers of routes for programs that use numbers, not chunks.

/// The chunks, bytes and cells that some isovalues need.
Response isovalues_response(const RouteCall& call);

/// The points of an isosurface as arrays.
Response samples_response(const RouteCall& call);

}  // namespace isosplat::server
