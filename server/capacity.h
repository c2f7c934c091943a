#pragma once

#include <cstdint>
#include <string>

#include "server/catalog/store_pool.h"
#include "server/limits/admission.h"
#include "server/routes/route_call.h"
#include "server/server.h"

namespace isosplat::server {

// Derives the limits of a server's parts from ServerLimits and from the limits of the system. The
// soft limit of open files is raised to the hard limit.

StorePool::Limits pool_limits(const ServerLimits& limits);
Admission::Limits admission_limits(const ServerLimits& limits);
RouterLimits router_limits(const ServerLimits& limits);

/// The maximum memory of bodies for one address. The address of a proxy stands for all of its
/// clients.
uint64_t bytes_of_one(const ServerLimits& limits);

/// The warning to log at the start if the system allows fewer open files than the limits need;
/// empty otherwise.
std::string descriptor_warning(const ServerLimits& limits);

}  // namespace isosplat::server
