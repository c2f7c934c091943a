#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "server/asio.h"
#include "shared/base/status.h"

namespace isosplat {

/// Listens on every address of a host, all on the same port (0: any free one). At least one.
/// Errors: io_error, which says what to do.
Result<std::vector<Acceptor>> listen(boost::asio::io_context& context, const std::string& host,
                                     uint16_t port);

}  // namespace isosplat
