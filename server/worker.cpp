#include "server/worker.h"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <memory>
#include <new>
#include <optional>
#include <thread>
#include <utility>

#include "server/http/message.h"

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// The only response of a refused connection, or null if it was admitted.
std::unique_ptr<Response> refusal_of(OpenConnection::Verdict verdict, const OriginPolicy& policy) {
  std::unique_ptr<Response> refusal;
  if (verdict == OpenConnection::Verdict::too_many) {
    refusal = std::make_unique<Response>(
        error_response(503, "too_many_connections",
                       "the server has reached its limit of connections: try again in a second"));
  } else if (verdict == OpenConnection::Verdict::too_many_from_one) {
    refusal = std::make_unique<Response>(error_response(
        429, "too_many_connections",
        "this address has reached its limit of connections: close some, or try again in a second"));
  }
  if (refusal) {
    refusal->set("Retry-After", "1");
    refusal->set("X-Content-Type-Options", "nosniff");
    policy.add_fields(*refusal);
  }
  return refusal;
}

/// An eighth of the shortest time limit of clients: a connection is closed at most this much late.
std::chrono::milliseconds interval_for(const ServerLimits& limits) {
  using std::chrono::milliseconds;
  const milliseconds shortest =
      std::min({limits.idle_time, limits.request_time, limits.write_time, limits.refusal_time,
                limits.patience, milliseconds(2000)});
  return std::max(shortest / 8, milliseconds(5));
}

}  // namespace

/// Registers a connection with its worker. Removes it and releases its entry in Admission when its
/// coroutine ends, also by an exception.
struct Worker::Membership {
  Membership(Worker& owner, Socket socket, std::unique_ptr<OpenConnection> held_slot,
             std::shared_ptr<TlsContext> tls)
      : worker(owner),
        slot(std::move(held_slot)),
        connection(
            std::make_unique<Connection>(std::move(socket), std::move(tls), owner.shared_, *slot)) {
    slot->set_close([&owner, id = slot->id()](OpenConnection::State chosen) {
      asio::post(owner.context_, [&owner, id, chosen] { owner.close_for_another(id, chosen); });
    });
    const auto added = worker.connections_.emplace(slot->id(), connection.get()).first;
    try {
      if (worker.connections_.size() == 1) worker.watch_deadlines();
    } catch (...) {
      worker.connections_.erase(added);
      throw;
    }
    Metrics& metrics = worker.shared_.metrics;
    ++(is_admitted() ? metrics.connections : metrics.connections_refused);
    ++metrics.connections_open;
  }
  /// For a connection of a proxy: counts it for this client from now on.
  void name(const std::string& client) {
    slot->name(client);
    if (!is_admitted()) ++worker.shared_.metrics.connections_refused;
  }
  Membership(const Membership&) = delete;
  Membership& operator=(const Membership&) = delete;
  ~Membership() {
    --worker.shared_.metrics.connections_open;
    worker.connections_.erase(slot->id());
    if (worker.shared_.stopping) worker.finish_if_done();
  }
  bool is_admitted() const { return slot->verdict() == OpenConnection::Verdict::admitted; }

  Worker& worker;
  std::unique_ptr<OpenConnection> slot;
  std::unique_ptr<Connection> connection;  ///< destroyed first
};

Worker::Worker(const ConnectionShared& shared)
    : shared_(shared),
      guard_(context_.get_executor()),
      watch_interval_(interval_for(shared.limits)) {}

void Worker::adopt(Socket socket, std::unique_ptr<OpenConnection> slot,
                   std::shared_ptr<TlsContext> tls) {
  asio::post(context_, [this, socket = std::move(socket), slot = std::move(slot),
                        tls = std::move(tls)]() mutable {
    asio::co_spawn(context_, serve(std::move(socket), std::move(slot), std::move(tls)),
                   asio::detached);
  });
}

void Worker::run() {
  bool is_watch_lost = false;
  while (true) {
    try {
      if (std::exchange(is_watch_lost, false)) watch_deadlines();
      context_.run();
      return;
    } catch (const std::bad_alloc&) {
      // A handler has thrown it. If it was the handler of a connection, this connection is closed.
      // It may have been the handler that watches deadlines.
      ++shared_.metrics.out_of_memory;
      is_watch_lost = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
}

/// Closes the connection that Admission has chosen, unless it has ended meanwhile.
void Worker::close_for_another(uint64_t connection, OpenConnection::State chosen) {
  const auto found = connections_.find(connection);
  if (found == connections_.end()) return;
  if (found->second->close_for_another(chosen)) ++shared_.metrics.connections_closed;
}

void Worker::stop(std::chrono::milliseconds time) {
  asio::post(context_, [this, time] {
    for (const auto& [id, connection] : connections_) connection->stop();
    deadline_.expires_after(time);
    deadline_.async_wait([this](const error_code& error) {
      if (!error) abort_all();
    });
    finish_if_done();
  });
}

void Worker::abort() {
  asio::post(context_, [this] { abort_all(); });
}

Awaitable<void> Worker::serve(Socket socket, std::unique_ptr<OpenConnection> slot,
                              std::shared_ptr<TlsContext> tls) {
  Membership membership(*this, std::move(socket), std::move(slot), std::move(tls));
  Connection& connection = *membership.connection;
  if (membership.is_admitted() && connection.has_proxy_header()) {
    const std::optional<std::string> client = co_await connection.read_proxy_header();
    if (!client) co_return;
    membership.name(*client);
  }
  co_await connection.run(refusal_of(membership.slot->verdict(), shared_.router.policy()));
}

void Worker::abort_all() {
  // The queued jobs belong to connections that are being closed.
  shared_.disk.stop();
  shared_.headers.stop();
  shared_.computing.stop();
  for (const auto& [id, connection] : connections_) connection->abort();
}

void Worker::watch_deadlines() {
  if (connections_.empty()) return;
  watch_.expires_after(watch_interval_);
  watch_.async_wait([this](const error_code& error) {
    if (error || connections_.empty()) return;
    const auto now = std::chrono::steady_clock::now();
    for (const auto& [id, connection] : connections_) connection->watch(now);
    watch_deadlines();
  });
}

void Worker::finish_if_done() {
  if (!connections_.empty()) return;
  watch_.cancel();
  deadline_.cancel();
  guard_.reset();
}

}  // namespace isosplat::server
