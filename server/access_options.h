#pragma once

#include <memory>
#include <string>
#include <vector>

#include "server/access/access_rules.h"
#include "server/access/origin_policy.h"
#include "server/server.h"

// Converts the options of a server to the rules of access.
namespace isosplat::server {

/// The host names that requests may have. `is_local`: the server listens on the loopback interface
/// only.
AllowedHosts allowed_hosts(const ServerOptions& options, bool is_local);

/// The rules of access from the options and from the current content of their files.
/// `fetched_keys`: the content of options.jwt_keys if that is a URL. It is empty if it could not be
/// fetched yet; no JWT is valid then. Errors: io_error (a file cannot be read), invalid_argument
/// (the content of a file); messages contain no secrets.
Result<std::shared_ptr<const AccessRules>> read_access(const ServerOptions& options,
                                                       std::string_view fetched_keys);

/// Whether ServerOptions::jwt_keys is an address, and not a file.
bool is_address(std::string_view keys);

/// Which pages may read the data, and by which hosts. `is_local`: the server listens on the
/// loopback interface only. Errors (invalid_argument): other machines can reach the server, and the
/// options do not state which pages may read.
Result<OriginPolicy> origin_policy(const ServerOptions& options, bool is_local);

/// A warning for each file of tokens or keys that other users of this machine can read or change.
std::vector<std::string> secret_file_warnings(const ServerOptions& options);

/// The warning about a server that other machines reach, without access control or without TLS.
std::string exposure_warning(const ServerOptions& options, uint16_t port, bool has_access_rules,
                             bool has_tls);

}  // namespace isosplat::server
