#include "server/worker.h"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/post.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "server/message.h"

namespace isosplat {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

/// The only response of a refused connection; null if it was admitted.
std::unique_ptr<Response> refusal_of(Admission::Verdict verdict, const OriginPolicy& policy) {
  std::unique_ptr<Response> refusal;
  if (verdict == Admission::Verdict::too_many) {
    refusal = std::make_unique<Response>(
        error_response(503, "too_many_connections",
                       "the server has reached its limit of connections: try again in a second"));
  } else if (verdict == Admission::Verdict::too_many_from_one) {
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

/// An eighth of the shortest time that a client has: so much later a connection may be closed.
std::chrono::milliseconds interval_for(const ServerLimits& limits) {
  using std::chrono::milliseconds;
  const milliseconds shortest =
      std::min({limits.idle_time, limits.request_time, limits.write_time, milliseconds(2000)});
  return std::max(shortest / 8, milliseconds(5));
}

}  // namespace

/// Registers a connection with its worker and with admission, and removes it when its coroutine
/// ends, also by an exception.
struct Worker::Membership {
  Membership(Worker& its_worker, Socket socket, std::string its_address,
             Admission::Verdict its_verdict, std::shared_ptr<TlsContext> tls)
      : worker(its_worker),
        address(std::move(its_address)),
        verdict(its_verdict),
        connection(std::make_unique<Connection>(std::move(socket), address, std::move(tls),
                                                its_worker.shared_, its_worker.waiting_)) {
    worker.connections_.insert(connection.get());
    if (worker.connections_.size() == 1) worker.watch_deadlines();
    Metrics& metrics = worker.shared_.metrics;
    ++(verdict == Admission::Verdict::admitted ? metrics.connections : metrics.connections_refused);
    ++metrics.connections_open;
  }
  /// For a connection of a proxy: it is one of this client from now on.
  void name(std::string client) {
    verdict = worker.admission_.name(client);
    address = std::move(client);
    if (verdict != Admission::Verdict::admitted) ++worker.shared_.metrics.connections_refused;
  }
  Membership(const Membership&) = delete;
  Membership& operator=(const Membership&) = delete;
  ~Membership() {
    --worker.shared_.metrics.connections_open;
    worker.connections_.erase(connection.get());
    worker.admission_.leave(address, verdict);
    if (worker.shared_.stopping) worker.finish_if_done();
  }
  Worker& worker;
  std::string address;
  Admission::Verdict verdict;
  std::unique_ptr<Connection> connection;
};

Worker::Worker(const ConnectionShared& shared, Admission& admission)
    : shared_(shared),
      admission_(admission),
      guard_(context_.get_executor()),
      watch_interval_(interval_for(shared.limits)) {}

void Worker::adopt(Socket socket, std::string address, Admission::Verdict verdict,
                   std::shared_ptr<TlsContext> tls) {
  asio::post(context_, [this, socket = std::move(socket), address = std::move(address), verdict,
                        tls = std::move(tls)]() mutable {
    asio::co_spawn(context_, serve(std::move(socket), std::move(address), verdict, std::move(tls)),
                   asio::detached);
  });
}

void Worker::close_longest_waiting() {
  asio::post(context_, [this] {
    if (Connection* const connection = waiting_.longest()) connection->abort();
  });
}

void Worker::stop(std::chrono::milliseconds time) {
  asio::post(context_, [this, time] {
    for (Connection* connection : connections_) connection->stop();
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

Awaitable<void> Worker::serve(Socket socket, std::string address, Admission::Verdict verdict,
                              std::shared_ptr<TlsContext> tls) {
  Membership membership(*this, std::move(socket), std::move(address), verdict, std::move(tls));
  Connection& connection = *membership.connection;
  if (verdict == Admission::Verdict::admitted && connection.has_proxy_header()) {
    std::optional<std::string> client = co_await connection.read_proxy_header();
    if (!client) co_return;
    membership.name(std::move(*client));
  }
  co_await connection.run(refusal_of(membership.verdict, shared_.router.policy()));
}

void Worker::abort_all() {
  // What is queued is for connections that end now.
  shared_.disk.stop();
  shared_.headers.stop();
  shared_.computing.stop();
  for (Connection* connection : connections_) connection->abort();
}

void Worker::watch_deadlines() {
  watch_.expires_after(watch_interval_);
  watch_.async_wait([this](const error_code& error) {
    if (error || connections_.empty()) return;
    const auto now = std::chrono::steady_clock::now();
    for (Connection* connection : connections_) connection->close_if_late(now);
    watch_deadlines();
  });
}

void Worker::finish_if_done() {
  if (!connections_.empty()) return;
  watch_.cancel();
  deadline_.cancel();
  guard_.reset();
}

}  // namespace isosplat
