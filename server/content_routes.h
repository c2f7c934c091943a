#pragma once

#include "server/routes.h"

namespace isosplat {

// What lies below /v1/volumes/{name}/{content}: bytes that never change under their URL.

Response header_answer(const RouteCall& call);
Response directory_page_answer(const RouteCall& call);
Response chunk_answer(const RouteCall& call);

/// The chunks of a level that an isovalue range needs, as frames.
Response chunks_answer(const RouteCall& call);

/// The chunks named, as frames.
Response batch_answer(const RouteCall& call);

/// The store file, or a range of it.
Response file_answer(const RouteCall& call);

}  // namespace isosplat
