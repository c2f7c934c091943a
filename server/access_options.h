#pragma once

#include <memory>

#include "server/access_rules.h"
#include "server/origin_policy.h"
#include "server/server.h"

// What the options of a server say about access.
namespace isosplat {

/// The hosts that requests may name. `is_local`: the server listens on the loopback interface only.
AllowedHosts allowed_hosts(const ServerOptions& options, bool is_local);

/// Who may read which volumes, as the options and their files say now. Errors: io_error (a file
/// cannot be read), invalid_argument (its contents); messages have no secrets.
Result<std::shared_ptr<const AccessRules>> read_access(const ServerOptions& options);

}  // namespace isosplat
