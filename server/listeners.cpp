#include "server/listeners.h"

#include <unistd.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <chrono>
#include <new>
#include <utility>

#include "server/access/ip_address.h"
#include "server/limits/memory_limit.h"
#include "server/net/listen.h"
#include "server/routes/refusals.h"

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using tcp = asio::ip::tcp;

/// Bytes that the process must be able to allocate for another connection.
constexpr uint64_t kConnectionBytes = 256 << 10;

}  // namespace

Result<void> Listeners::open(const ServerOptions& options) {
  auto acceptors = options.sockets.empty() ? listen(control_, options.host, options.port)
                                           : take_over(control_, options.sockets);
  if (!acceptors) return tl::unexpected(acceptors.error());
  acceptors_ = std::move(*acceptors);
  port_ = acceptors_.front().local_endpoint().port();
  if (!options.http_port) {
    // The previous process had the port, but the configuration has changed.
    for (const int socket : options.redirecting_sockets) ::close(socket);
    return {};
  }
  auto redirecting = options.redirecting_sockets.empty()
                         ? listen(control_, options.host, *options.http_port)
                         : take_over(control_, options.redirecting_sockets);
  if (!redirecting) return tl::unexpected(redirecting.error());
  redirecting_ = std::move(*redirecting);
  return {};
}

uint16_t Listeners::redirecting_port() const {
  if (redirecting_.empty()) return 0;
  error_code error;
  return redirecting_.front().local_endpoint(error).port();
}

bool Listeners::is_local() const {
  return std::ranges::all_of(acceptors_, [](const Acceptor& acceptor) {
    error_code error;
    return acceptor.local_endpoint(error).address().is_loopback() && !error;
  });
}

ListeningSockets Listeners::sockets() {
  ListeningSockets sockets;
  for (Acceptor& acceptor : acceptors_) sockets.serving.push_back(acceptor.native_handle());
  for (Acceptor& acceptor : redirecting_) sockets.redirecting.push_back(acceptor.native_handle());
  return sockets;
}

void Listeners::start() {
  for (Acceptor& acceptor : acceptors_) {
    asio::co_spawn(control_, accept_on(acceptor, true), asio::detached);
  }
  for (Acceptor& acceptor : redirecting_) {
    asio::co_spawn(control_, accept_on(acceptor, false), asio::detached);
  }
}

void Listeners::close() {
  error_code ignored;
  for (auto* each : {&acceptors_, &redirecting_}) {
    for (Acceptor& acceptor : *each) acceptor.close(ignored);
  }
}

Awaitable<void> Listeners::accept_on(Acceptor& acceptor, bool has_tls) {
  Timer pause(control_.get_executor());
  while (!shared_.stopping) {
    Worker& worker = *workers_[next_worker_++ % workers_.size()];
    Socket socket(worker.context().get_executor());
    tcp::endpoint peer;
    error_code error;
    co_await acceptor.async_accept(socket, peer, await(error));
    if (shared_.stopping || error == asio::error::operation_aborted) co_return;
    bool is_served = false;
    try {
      is_served = !error && has_memory_for(kConnectionBytes);
      if (is_served) admit(worker, std::move(socket), peer, has_tls);
      // The likely cause is a lack of file descriptors or memory. Connections that end will free
      // some.
      if (!is_served) admission_.make_room(std::chrono::steady_clock::now());
    } catch (const std::bad_alloc&) {
      is_served = false;
    }
    if (is_served) continue;
    if (!error) ++shared_.metrics.out_of_memory;
    error_code ignored;
    socket.close(ignored);
    pause.expires_after(std::chrono::milliseconds(10));
    co_await pause.async_wait(await(ignored));
  }
}

/// Passes a connection to a worker, or refuses it.
void Listeners::admit(Worker& worker, Socket socket, const tcp::endpoint& peer, bool has_tls) {
  const IpAddress peer_address = IpAddress::of(*peer.data()).value_or(IpAddress{});
  const bool is_of_proxy = shared_.proxies.trusts(peer_address);
  auto slot = admission_.enter(is_of_proxy ? Admission::kOfProxy : peer_address.client_key(),
                               std::chrono::steady_clock::now());
  if (!slot) {
    ++shared_.metrics.connections_refused;
    if (shared_.log.has_access_log()) {
      shared_.log.access(refusal_line(shared_.log_format, peer_address.client_key(), 0, 0));
    }
    return;
  }
  worker.adopt(std::move(socket), std::move(slot), has_tls ? tls_.context() : nullptr);
}

}  // namespace isosplat::server
