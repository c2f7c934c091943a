#include "server/net/listen.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <boost/asio/ip/v6_only.hpp>
#include <utility>

namespace isosplat::server {

namespace asio = boost::asio;
using boost::system::error_code;
using tcp = asio::ip::tcp;

Result<std::vector<Acceptor>> listen(asio::io_context& context, const std::string& host,
                                     uint16_t port) {
  error_code error;
  std::vector<Acceptor> acceptors;
  tcp::resolver resolver(context);
  const auto found = resolver.resolve(host, std::to_string(port), tcp::resolver::passive, error);
  if (error) return fail(Status::io_error, fmt::format("host {}: {}", host, error.message()));
  error_code last_error;
  for (const auto& entry : found) {
    tcp::endpoint endpoint = entry.endpoint();
    endpoint.port(port);
    Acceptor acceptor(context.get_executor());
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error && endpoint.address().is_v6()) {
      // "::" accepts IPv4 as well. Other names, such as "localhost", resolve to an address of each
      // kind.
      acceptor.set_option(asio::ip::v6_only(!endpoint.address().is_unspecified()), error);
    }
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error == asio::error::address_in_use || error == asio::error::access_denied) {
      return fail(Status::io_error,
                  fmt::format("port {} of {}: {}: choose another port, or 0 for a free one", port,
                              endpoint.address().to_string(), error.message()));
    }
    if (error) {
      last_error = error;  // for example an IPv6 address on a machine without IPv6
      continue;
    }
    port = acceptor.local_endpoint(error).port();
    acceptors.push_back(std::move(acceptor));
  }
  if (!acceptors.empty()) return acceptors;
  return fail(Status::io_error,
              fmt::format("host {}: cannot listen: {}", host, last_error.message()));
}

Result<std::vector<Acceptor>> take_over(asio::io_context& context,
                                        const std::vector<int>& sockets) {
  std::vector<Acceptor> acceptors;
  for (const int socket : sockets) {
    sockaddr_storage address{};
    socklen_t length = sizeof address;
    int listens = 0;
    socklen_t size = sizeof listens;
    const bool is_known =
        ::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length) == 0 &&
        (address.ss_family == AF_INET || address.ss_family == AF_INET6) &&
        ::getsockopt(socket, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) == 0 && listens != 0;
    error_code error;
    Acceptor acceptor(context.get_executor());
    if (is_known) {
      acceptor.assign(address.ss_family == AF_INET ? tcp::v4() : tcp::v6(), socket, error);
    }
    if (!is_known || error) {
      return fail(Status::io_error,
                  fmt::format("socket {}: expected a listening socket of TCP (ListenStream= with a "
                              "port)",
                              socket));
    }
    acceptors.push_back(std::move(acceptor));
  }
  return acceptors;
}

}  // namespace isosplat::server
