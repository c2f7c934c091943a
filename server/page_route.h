#pragma once

#include "server/routes.h"

namespace isosplat {

/// A file of the page. HTML that is asked for with a volume in its query has the browser fetch the
/// volume's first bytes at once, beside what the page is made of.
Response page_answer(const RouteCall& call);

}  // namespace isosplat
