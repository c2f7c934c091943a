#pragma once

#include "server/routes.h"

namespace isosplat {

// Handlers of the routes below /v1/volumes/{name}/{content}, whose bytes never change.

Response header_response(const RouteCall& call);
Response directory_page_response(const RouteCall& call);
Response chunk_response(const RouteCall& call);

/// The chunks of a level for an isovalue range, as frames.
Response chunks_response(const RouteCall& call);

/// The chunks of a list, as frames.
Response batch_response(const RouteCall& call);

/// The store file, or a range of it.
Response file_response(const RouteCall& call);

}  // namespace isosplat
