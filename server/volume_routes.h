#pragma once

#include "server/routes.h"

namespace isosplat {

// What lies above the content ids: it may change at any time.

Response health_answer(const RouteCall& call);
Response volumes_answer(const RouteCall& call);
Response volume_answer(const RouteCall& call);

/// What a viewer needs for its first picture, in one answer.
Response bootstrap_answer(const RouteCall& call);

}  // namespace isosplat
