#pragma once

#include "server/routes/route_call.h"

namespace isosplat::server {

// Handlers of the routes without a content id, whose responses may change at any time.

Response health_response(const RouteCall& call);

/// The description of the routes for programs.
Response openapi_response(const RouteCall& call);

/// The list of volumes or scenes.
Response list_response(const RouteCall& call, ServedKind kind);
Response volumes_response(const RouteCall& call);
Response volume_response(const RouteCall& call);

/// Everything that a viewer needs for its first picture, in one response.
Response bootstrap_response(const RouteCall& call);

}  // namespace isosplat::server
