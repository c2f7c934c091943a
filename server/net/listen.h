#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "server/net/asio.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// Listens on all addresses of a host, on the same port (0: any free port). Addresses that the
/// machine does not support are skipped. Returns at least one acceptor. Errors: io_error.
Result<std::vector<Acceptor>> listen(boost::asio::io_context& context, const std::string& host,
                                     uint16_t port);

/// Takes over listening TCP sockets. Errors (io_error): a descriptor is not one.
Result<std::vector<Acceptor>> take_over(boost::asio::io_context& context,
                                        const std::vector<int>& sockets);

}  // namespace isosplat::server
