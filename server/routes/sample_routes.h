#pragma once

#include "server/routes/route_call.h"

namespace isosplat::server {

// Handlers of routes for programs that want numbers, not chunks.

/// What some isovalues need: chunks, bytes and cells.
Response isovalues_response(const RouteCall& call);

/// The points of an isosurface as arrays.
Response samples_response(const RouteCall& call);

}  // namespace isosplat::server
