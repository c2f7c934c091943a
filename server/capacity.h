#pragma once

#include <cstdint>
#include <string>

#include "server/catalog/store_pool.h"
#include "server/limits/admission.h"
#include "server/routes/route_call.h"
#include "server/server.h"

namespace isosplat::server {

// The limits of a server's parts: those of ServerLimits, within what the system allows. The soft
// limit of open files is raised to the hard limit.

StorePool::Limits pool_limits(const ServerLimits& limits);
Admission::Limits admission_limits(const ServerLimits& limits);
RouterLimits router_limits(const ServerLimits& limits);

/// The memory of bodies that one address may take. A proxy's address is that of all clients.
uint64_t bytes_of_one(const ServerLimits& limits);

/// What the log says at the start if the system allows fewer open files than the limits need; else
/// nothing.
std::string descriptor_warning(const ServerLimits& limits);

}  // namespace isosplat::server
