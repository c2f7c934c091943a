#include "server/connection.h"

#include <netinet/tcp.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <new>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "server/access/ip_address.h"
#include "server/access/proxy_header.h"
#include "server/http/request_parser.h"
#include "server/http/response_header.h"
#include "server/http/streams.h"
#include "server/limits/memory_limit.h"
#include "server/net/tcp_progress.h"
#include "server/routes/refusals.h"

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;
using tcp = asio::ip::tcp;

using Clock = std::chrono::steady_clock;

/// How much the system keeps for a client that is slow to read (TCP_NOTSENT_LOWAT), in bytes; by
/// default megabytes. What is on its way to a fast client does not count.
using UnsentBytes = asio::detail::socket_option::integer<IPPROTO_TCP, TCP_NOTSENT_LOWAT>;

// What the process must be able to allocate (has_memory_for), besides what the body takes.
constexpr uint64_t kRequestBytes = 1 << 20;     // for any request
constexpr uint64_t kComputingBytes = 16 << 20;  // for a turn that computes

/// How much is read of a request at a time: all of most requests.
constexpr size_t kReadBytes = 4096;

constexpr Clock::time_point kNever = Clock::time_point::max();

using Bytes = std::span<const std::byte>;

std::array<asio::const_buffer, 2> buffers_of(Bytes first, Bytes second) {
  return {asio::const_buffer(first.data(), first.size()),
          asio::const_buffer(second.data(), second.size())};
}

/// The body of a response without a stream.
Bytes body_of(const Response& response) {
  return response.bytes.data() != nullptr ? response.bytes
                                          : std::as_bytes(std::span(response.text));
}

/// Some bytes of a body that is produced while it is sent.
struct Piece {
  std::vector<std::byte> bytes;
  BodyStream::Step step = BodyStream::Step::more;
  Error error;  ///< if broken; without a message: as `outcome` says
  WorkPool::Outcome outcome = WorkPool::Outcome::done;

  void clear() {
    bytes.clear();
    step = BodyStream::Step::more;
  }
};

}  // namespace

struct Connection::State {
  Socket socket;
  std::string address;   ///< of the client of the present request
  std::string groups{};  ///< of the same, as a trusted proxy says
  std::shared_ptr<TlsContext> tls_context;
  const ConnectionShared& shared;
  OpenConnection& place;
  beast::flat_buffer buffer;
  std::string client{};  ///< whom the present request counts for: its token, or its address
  std::optional<asio::ssl::stream<Socket&>> tls{};  ///< over `socket`; absent without TLS
  Clock::time_point deadline = kNever;              ///< of what it waits for from the client
  Clock::time_point end = kNever;                   ///< of the connection, if it is refused
  IpAddress peer{};  ///< the other end, or the client that a header of the PROXY protocol names
  bool is_idle = false;
  bool is_writing = false;       ///< the client must take a piece of the response until `deadline`
  bool is_local = false;         ///< the peer is on this machine
  WorkPool* pool = nullptr;      ///< in which `job` is
  WorkPool::Job* job = nullptr;  ///< what it waits for; null: nothing
  uint64_t body_bytes = 0;       ///< of the last response, as far as they were sent

  /// What the client has acknowledged: at the last measurement of its rate, and when it was late.
  uint64_t measured_bytes = 0;
  Clock::time_point measured_at = kNever;  ///< kNever: not yet
  std::optional<uint64_t> late_bytes{};

  void set_state(OpenConnection::State state, Clock::time_point now = Clock::now()) {
    measured_at = kNever;
    place.set_state(state, now);
  }

  void expires_after(Clock::duration time, Clock::time_point now = Clock::now()) {
    deadline = std::min(now + time, end);
    late_bytes.reset();
  }

  /// What waits for the client then fails. Bytes that it has not taken are dropped, if there are
  /// any: the system would keep them as long as it takes a few now and then.
  void close() {
    deadline = kNever;
    if (!socket.is_open()) return;
    if (unacknowledged_bytes(socket.native_handle()) > 0) reset_on_close(socket.native_handle());
    error_code ignored;
    socket.close(ignored);
  }

  void measure_rate(Clock::time_point now);
  bool still_takes_bytes();

  /// Reads some bytes into `buffer`; nothing is read if the connection ends.
  Awaitable<error_code> read_some();

  // These return false if the connection must be closed.
  Awaitable<bool> shake_hands();
  Awaitable<bool> write(Bytes first, Bytes second);
  Awaitable<bool> write_response(Response& response, Piece& piece, bool close, bool http_1_0,
                                 bool head);
  Awaitable<bool> wait_for_request();
  Awaitable<HeaderScan> read_header(size_t scanned);
  Awaitable<Response> respond(const Request& request);
  Awaitable<Response> respond_elsewhere(const Request& request, RoutedCall& call);
  Awaitable<Response> respond_within_rates(const Request& request, ByteBudget::Share& memory,
                                           Piece& piece);
  Awaitable<Response> compute_response(const Request& request, RoutedCall& call);
  template <class Task>
  Awaitable<WorkPool::Outcome> run_in(WorkPool& its_pool, WorkPool::Kind kind, Task& task);
  bool has_left(const WorkPool& its_pool);
  std::optional<Response> admit_client(const std::string& name);
  Response refuse_for_now(const Request& request, const Route* route,
                          WorkPool::Outcome outcome) const;
  bool send_at_once(Bytes& first, Bytes& second);
  HeaderScan scan_received(size_t& scanned);
  void identify_client(const RequestParser& parser, Request& request);
  bool read_in_memory(const Response& response, Piece& piece);
  Awaitable<void> read_elsewhere(const Response& response, Piece& piece);
  /// Those of responses that the router has not made.
  Response refuse_for_memory(const Request& request, const Route* route, Piece& piece) const;
  void add_fields(const Request& request, Response& response) const {
    response.set("X-Content-Type-Options", "nosniff");
    shared.router.policy().add_fields(request, response);
  }
  Response error_of(const Piece& piece, const Request& request, const Route* route) const;
  Awaitable<void> compute_piece(BodyStream& body, Piece& piece);
  Awaitable<bool> handle_request();
  Awaitable<void> linger();
  Awaitable<void> drain();
  void report_fault(std::string_view message) {
    ++shared.metrics.faults;
    shared.log.fault(message);
  }
  void write_access_log(const RequestParser& parser, const Request& request,
                        const Response& response, std::string_view id, Clock::duration duration);

  /// Counts and logs a connection whose request was not read. `status`: 0 without a response.
  void record_refusal(int status) {
    shared.metrics.add_response(Metrics::kNoRoute, status, body_bytes, {});
    if (!shared.log.has_access_log()) return;
    shared.log.access(refusal_line(shared.log_format, address, status, body_bytes));
  }
};

Connection::Connection(Socket socket, std::shared_ptr<TlsContext> tls,
                       const ConnectionShared& shared, OpenConnection& place)
    : state_(new State{std::move(socket),
                       {},
                       {},
                       std::move(tls),
                       shared,
                       place,
                       // A header of the largest size, and one more read.
                       beast::flat_buffer(shared.limits.header_bytes + 8192)}) {
  error_code error;
  const tcp::endpoint peer = state_->socket.remote_endpoint(error);
  state_->peer = IpAddress::of(*peer.data()).value_or(IpAddress{});
  state_->is_local = state_->peer.is_loopback() && !error;
  state_->socket.non_blocking(true, error);
}

Connection::~Connection() = default;

void Connection::stop() {
  error_code ignored;
  if (state_->is_idle) state_->socket.cancel(ignored);
}

void Connection::abort() {
  state_->close();
}

bool Connection::close_for_another(OpenConnection::State chosen) {
  const bool is_as_chosen = state_->place.state() == chosen;
  if (is_as_chosen) {
    state_->close();
  } else {
    state_->place.keep();
  }
  return is_as_chosen;
}

void Connection::watch(std::chrono::steady_clock::time_point now) {
  State& state = *state_;
  if (state.job && state.has_left(*state.pool)) state.pool->withdraw(*state.job);
  if (!state.socket.is_open()) return;
  if (state.place.state() == OpenConnection::State::sending) state.measure_rate(now);
  if (now <= state.deadline) return;
  if (!state.is_writing && now <= state.end && state.still_takes_bytes()) {
    state.deadline = std::min(now + state.shared.limits.write_time, state.end);
  } else {
    state.close();
  }
}

/// Twice within `patience`, while the client takes a response.
void Connection::State::measure_rate(Clock::time_point now) {
  if (measured_at != kNever && now - measured_at < shared.limits.patience / 2) return;
  const uint64_t bytes = acknowledged_bytes(socket.native_handle());
  if (measured_at != kNever) {
    const double seconds = std::chrono::duration<double>(now - measured_at).count();
    place.set_rate(static_cast<uint64_t>(static_cast<double>(bytes - measured_bytes) / seconds));
  }
  measured_bytes = bytes;
  measured_at = now;
}

/// Whether the client, which is late with something else, still takes a response that was sent, and
/// has taken a piece of it since the last call.
bool Connection::State::still_takes_bytes() {
  if (unacknowledged_bytes(socket.native_handle()) == 0) return false;
  const uint64_t bytes = acknowledged_bytes(socket.native_handle());
  const bool goes_on = !late_bytes || bytes - *late_bytes >= kPieceBytes;
  late_bytes = bytes;
  return goes_on;
}

Awaitable<void> Connection::run(std::unique_ptr<Response> refusal) {
  State& state = *state_;
  error_code ignored;
  state.address = state.peer.client_key();
  state.socket.set_option(tcp::no_delay(true), ignored);
  state.socket.set_option(UnsentBytes(2 * kPieceBytes), ignored);
  if (refusal) state.end = Clock::now() + state.shared.limits.refusal_time;
  state.set_state(OpenConnection::State::waiting);
  if (state.tls_context && !co_await state.shake_hands()) {
    ++state.shared.metrics.tls_failures;
    if (refusal) state.record_refusal(0);
    state.close();
    co_return;
  }
  if (refusal) {
    Piece none;
    const bool sent = co_await state.write_response(*refusal, none, true, false, false);
    state.record_refusal(refusal->status);
    if (sent) co_await state.linger();
  } else {
    // Two statements: g++ 12 evaluates both sides of "co_await a && co_await b" in any case.
    try {
      for (bool is_open = true; is_open;) {
        is_open = co_await state.wait_for_request();
        if (is_open) is_open = co_await state.handle_request();
      }
    } catch (const std::bad_alloc&) {
      ++state.shared.metrics.out_of_memory;
      state.close();
      co_return;
    }
  }
  co_await state.drain();
  state.close();
}

bool Connection::has_proxy_header() const {
  return state_->shared.proxies.send_proxy_header(state_->peer);
}

Awaitable<std::optional<std::string>> Connection::read_proxy_header() {
  State& state = *state_;
  state.set_state(OpenConnection::State::waiting);
  state.expires_after(state.shared.limits.request_time);
  ProxyHeader header;
  while (header.state == ProxyHeader::State::partial) {
    if (co_await state.read_some()) break;
    header = parse_proxy_header(
        {static_cast<const char*>(state.buffer.data().data()), state.buffer.size()});
  }
  if (header.state != ProxyHeader::State::complete) {
    state.close();
    co_return std::nullopt;
  }
  state.buffer.consume(header.bytes);
  if (header.source) state.peer = *header.source;
  // A client that the proxy does not know may be anywhere.
  state.is_local = state.peer.is_loopback() && (header.source || header.is_local);
  co_return state.peer.client_key();
}

/// The handshake of TLS, within request_time.
Awaitable<bool> Connection::State::shake_hands() {
  expires_after(shared.limits.request_time);
  if (buffer.size() == 0) {
    // A client that sends nothing costs no state of TLS.
    const auto [none] = co_await socket.async_wait(Socket::wait_read, kAwait);
    if (none) co_return false;
  }
  tls.emplace(socket, *tls_context);
  // What was read behind a header of the PROXY protocol is the begin of the handshake.
  const auto [error, used] =
      co_await tls->async_handshake(asio::ssl::stream_base::server, buffer.data(), kAwait);
  buffer.consume(used);
  co_return !error;
}

Awaitable<error_code> Connection::State::read_some() {
  std::tuple<error_code, size_t> result;
  if (tls) {
    result = co_await tls->async_read_some(buffer.prepare(kReadBytes), kAwait);
  } else {
    result = co_await socket.async_read_some(buffer.prepare(kReadBytes), kAwait);
  }
  const auto [error, bytes] = result;
  if (!error) buffer.commit(bytes);
  co_return error;
}

/// Waits for the first byte of a request, up to idle_time.
Awaitable<bool> Connection::State::wait_for_request() {
  const Clock::time_point now = Clock::now();
  set_state(OpenConnection::State::waiting, now);
  if (buffer.size() > 0) {
    // Other connections of this thread have their turn before the next of many requests.
    co_await asio::post(kAwait);
    co_return true;
  }
  if (shared.stopping) co_return false;
  if (buffer.capacity() > kReadBytes) buffer.shrink_to_fit();
  expires_after(shared.limits.idle_time, now);
  is_idle = true;
  const error_code error = co_await read_some();
  is_idle = false;
  co_return !error;
}

/// Looks for the end of a request's header in what was received. `scanned`: what an earlier call
/// has scanned of it; is set.
HeaderScan Connection::State::scan_received(size_t& scanned) {
  std::string_view received(static_cast<const char*>(buffer.data().data()), buffer.size());
  // Empty lines before a request are ignored (RFC 9112, 2.2).
  while (scanned == 0 && received.starts_with("\r\n")) {
    buffer.consume(2);
    received.remove_prefix(2);
  }
  if (received == "\r") return {};  // perhaps the begin of an empty line
  HeaderScan scan =
      scan_header(received, scanned, shared.limits.header_bytes, shared.limits.target_bytes);
  scanned = received.size();
  return scan;
}

/// Reads the rest of a request's header within request_time. Returns the state partial if the
/// connection ends before the header is complete.
Awaitable<HeaderScan> Connection::State::read_header(size_t scanned) {
  expires_after(shared.limits.request_time);
  while (!co_await read_some()) {
    HeaderScan scan = scan_received(scanned);
    if (scan.state != HeaderScan::State::partial) co_return scan;
  }
  co_return HeaderScan{};
}

// A request is tried on this thread first: most of the time the system holds the bytes in memory,
// and another thread would cost more than the read. What needs the disk, or much processor time, is
// repeated in a pool. Few threads compute, so they do not wait for a disk: what they lack is read
// by the threads for disks first.

Awaitable<Response> Connection::State::respond(const Request& request) {
  NoWait no_wait;
  bool is_admitted = false;
  const auto admit = [&](const std::string& name) {
    is_admitted = true;
    return admit_client(name);
  };
  RoutedCall call = shared.router.route(request, admit);
  Response response = call.respond(ThreadKind::connection, &no_wait);
  if (!is_admitted) {
    if (auto refusal = admit_client({})) {
      response = std::move(*refusal);
      add_fields(request, response);
    }
  }
  if (!no_wait.needs_disk) {
    ++shared.metrics.reads_in_memory;
    co_return response;
  }
  co_return co_await respond_elsewhere(request, call);
}

/// From now on the request counts for the client of this name, or for its address if that is empty.
/// Returns the response if it has used up its rate.
std::optional<Response> Connection::State::admit_client(const std::string& name) {
  client = name.empty() ? address : "client " + name;
  place.set_client(client);
  const auto seconds = shared.rates.take_request(client, Clock::now());
  if (!seconds) return std::nullopt;
  return rate_response(*seconds);
}

/// Runs the task in the pool, as one of the client. It is withdrawn if the client leaves.
template <class Task>
Awaitable<WorkPool::Outcome> Connection::State::run_in(WorkPool& its_pool, WorkPool::Kind kind,
                                                       Task& task) {
  WorkPool::Outcome outcome = WorkPool::Outcome::withdrawn;
  if (!has_left(its_pool)) {
    WorkPool::Job its_job(client, kind, task);
    pool = &its_pool;
    job = &its_job;
    std::exception_ptr thrown;
    try {
      outcome = co_await its_pool.run(its_job);
    } catch (...) {
      thrown = std::current_exception();
    }
    job = nullptr;
    if (thrown) std::rethrow_exception(thrown);
  }
  if (outcome == WorkPool::Outcome::withdrawn) ++shared.metrics.work_cancelled;
  if (outcome == WorkPool::Outcome::refused) ++shared.metrics.computations_refused;
  co_return outcome;
}

/// Whether nobody waits for what the pool does. Points are costly: a client that ends its side is
/// taken for one that has left, although it could still read.
bool Connection::State::has_left(const WorkPool& its_pool) {
  if (!socket.is_open()) return true;
  const TcpEnd end_of_client = tcp_end(socket.native_handle());
  return end_of_client == TcpEnd::reset ||
         (end_of_client == TcpEnd::ended && &its_pool == &shared.computing);
}

/// The response of a handler that needs a disk, or computes.
Awaitable<Response> Connection::State::respond_elsewhere(const Request& request, RoutedCall& call) {
  const Route* const route = call.route();
  if (route->work == RouteWork::computes) co_return co_await compute_response(request, call);
  const bool is_of_many = route->work == RouteWork::reads_headers;
  WorkPool& its_pool = is_of_many ? shared.headers : shared.disk;
  Response response;
  WorkTurn turn;
  auto repeat = [&] { response = call.respond(ThreadKind::disk, nullptr, &turn); };
  do {
    turn.is_unfinished = false;
    const auto outcome = co_await run_in(its_pool, WorkPool::Kind::first, repeat);
    if (outcome != WorkPool::Outcome::done) co_return refuse_for_now(request, route, outcome);
  } while (turn.is_unfinished);
  co_return response;
}

Awaitable<Response> Connection::State::compute_response(const Request& request, RoutedCall& call) {
  Response response;
  WorkTurn turn;
  NoWait no_wait;
  bool may_wait = false;
  auto compute = [&] {
    // Waits where the system keeps nothing in memory of what was read.
    response = call.respond(ThreadKind::computing, may_wait ? nullptr : &no_wait, &turn);
  };
  auto fetch = [&] { call.respond(ThreadKind::disk, nullptr, &turn); };
  auto kind = WorkPool::Kind::first;
  while (true) {
    if (!has_memory_for(kComputingBytes)) throw std::bad_alloc();
    turn.is_unfinished = false;
    auto outcome = co_await run_in(shared.computing, kind, compute);
    kind = WorkPool::Kind::continued;
    if (outcome == WorkPool::Outcome::done && !may_wait && no_wait.needs_disk) {
      may_wait = true;
      do {
        turn.is_unfinished = false;
        outcome = co_await run_in(shared.disk, kind, fetch);
      } while (outcome == WorkPool::Outcome::done && turn.is_unfinished);
      turn.is_unfinished = true;
    }
    if (outcome != WorkPool::Outcome::done) {
      co_return refuse_for_now(request, call.route(), outcome);
    }
    if (!turn.is_unfinished) co_return response;
  }
}

/// The response if the server stops, or computes too much. One of the status 0 is not sent: the
/// client has left.
Response Connection::State::refuse_for_now(const Request& request, const Route* route,
                                           WorkPool::Outcome outcome) const {
  const bool is_stopping = outcome == WorkPool::Outcome::stopped;
  Response response =
      busy_response(is_stopping ? "the server is stopping"
                                : "the server is computing as much as it can, for this client or "
                                  "for others: try again in a second");
  response.route = route;
  response.close = outcome != WorkPool::Outcome::refused;
  if (outcome == WorkPool::Outcome::withdrawn) response.status = 0;
  add_fields(request, response);
  return response;
}

/// The response if the process cannot have more memory. `piece`: what there was of another one.
Response Connection::State::refuse_for_memory(const Request& request, const Route* route,
                                              Piece& piece) const {
  ++shared.metrics.out_of_memory;
  piece = {};
  Response response = busy_response("the server has no memory left: try again in a second");
  response.route = route;
  add_fields(request, response);
  return response;
}

/// The response, within the limits of the client and of the memory of bodies. `memory`: what
/// the response takes of it. `piece`: becomes the first of its stream.
Awaitable<Response> Connection::State::respond_within_rates(const Request& request,
                                                            ByteBudget::Share& memory,
                                                            Piece& piece) {
  Response response = co_await respond(request);
  if (request.method == Method::head || response.status == 0) co_return response;
  if (response.stream && !has_memory_for(response.memory())) {
    co_return refuse_for_memory(request, response.route, piece);
  }
  if (memory.take(shared.bytes_in_flight, response.memory(), client)) {
    if (response.stream && response.body_size() > 0) {
      if (!read_in_memory(response, piece)) co_await read_elsewhere(response, piece);
      // Nothing was sent yet: a client can tell an error from a lost connection.
      if (piece.step == BodyStream::Step::broken && piece.bytes.empty()) {
        response = error_of(piece, request, response.route);
      }
    }
    shared.rates.take_bytes(client, response.body_size(), Clock::now());
    co_return response;
  }
  response = busy_response(
      "the server is sending as much as it has memory for, to all or to this client: try again in "
      "a second");
  add_fields(request, response);
  co_return response;
}

/// The response if the first piece of a stream cannot be read.
Response Connection::State::error_of(const Piece& piece, const Request& request,
                                     const Route* route) const {
  if (piece.error.message.empty()) return refuse_for_now(request, route, piece.outcome);
  Response response = error_response(piece.error);
  response.route = route;
  add_fields(request, response);
  return response;
}

/// The next bytes of a body, if they need neither a disk nor computing; `piece` is clear. Not a
/// coroutine, which would need a frame for each piece. Returns false for read_elsewhere().
bool Connection::State::read_in_memory(const Response& response, Piece& piece) {
  if (response.route && response.route->work == RouteWork::computes) return false;
  NoWait no_wait;
  piece.step = response.stream->next(piece.bytes, piece.error, &no_wait);
  if (no_wait.needs_disk && piece.bytes.empty()) return false;
  ++shared.metrics.reads_in_memory;
  return true;
}

/// The next bytes of a body that read_in_memory() cannot read.
Awaitable<void> Connection::State::read_elsewhere(const Response& response, Piece& piece) {
  BodyStream& body = *response.stream;
  if (response.route && response.route->work == RouteWork::computes) {
    co_await compute_piece(body, piece);
    co_return;
  }
  auto repeat = [&] { piece.step = body.next(piece.bytes, piece.error, nullptr); };
  piece.outcome = co_await run_in(shared.disk, WorkPool::Kind::continued, repeat);
  if (piece.outcome != WorkPool::Outcome::done) piece.step = BodyStream::Step::broken;
}

/// The same for a body that is computed.
Awaitable<void> Connection::State::compute_piece(BodyStream& body, Piece& piece) {
  constexpr auto kKind = WorkPool::Kind::continued;
  while (true) {
    NoWait no_wait;
    auto compute = [&] { piece.step = body.next(piece.bytes, piece.error, &no_wait); };
    piece.outcome = co_await run_in(shared.computing, kKind, compute);
    const bool has_run = piece.outcome == WorkPool::Outcome::done;
    if (has_run && (!no_wait.needs_disk || !piece.bytes.empty())) co_return;
    piece.step = BodyStream::Step::broken;  // unless it goes on
    if (!has_run) co_return;
    Result<void> fetched;
    auto fetch = [&] { fetched = body.fetch(); };
    piece.outcome = co_await run_in(shared.disk, kKind, fetch);
    if (!fetched) piece.error = fetched.error();
    if (piece.outcome != WorkPool::Outcome::done || !fetched) co_return;
  }
}

Awaitable<bool> Connection::State::handle_request() {
  size_t scanned = 0;
  HeaderScan header = scan_received(scanned);
  if (header.state == HeaderScan::State::partial) header = co_await read_header(scanned);
  const Clock::time_point begin = Clock::now();
  set_state(OpenConnection::State::serving, begin);
  deadline = kNever;  // no longer the client's time
  if (header.state == HeaderScan::State::partial) co_return false;
  RequestParser parser;
  std::optional<Response> refusal = std::move(header.refusal);
  if (!refusal) {
    refusal = parser.parse({static_cast<const char*>(buffer.data().data()), header.bytes});
    buffer.consume(header.bytes);
  }
  Request request = parser.request();
  identify_client(parser, request);
  ByteBudget::Share memory;
  Response response;
  Piece piece;
  if (refusal) {
    response = std::move(*refusal);
  } else {
    bool has_memory = has_memory_for(kRequestBytes);
    try {
      if (has_memory) response = co_await respond_within_rates(request, memory, piece);
    } catch (const std::bad_alloc&) {
      has_memory = false;
    }
    if (!has_memory) response = refuse_for_memory(request, response.route, piece);
  }
  if (!response.fault.empty()) report_fault(response.fault);

  std::string id;
  const bool has_id = is_request_id(request.request_id);
  if (has_id || shared.log.has_access_log()) id = request_id(request.request_id);
  if (has_id) response.set("X-Request-Id", id);
  const bool close = response.close || !parser.keep_alive() || shared.stopping;
  bool sent = false;
  body_bytes = 0;
  if (response.status != 0) {
    sent = co_await write_response(response, piece, close, parser.is_http_1_0(),
                                   request.method == Method::head);
  }
  const Clock::duration duration = Clock::now() - begin;
  shared.metrics.add_response(response.route ? index_of(*response.route) : Metrics::kNoRoute,
                              response.status, body_bytes, duration);
  write_access_log(parser, request, response, id, duration);
  if (!sent) co_return false;
  if (close) co_await linger();
  co_return !close;
}

/// Sets `address` and what the request says about its origin: of the client that a trusted proxy
/// names, or else of the peer.
void Connection::State::identify_client(const RequestParser& parser, Request& request) {
  request.is_from_this_machine = is_local;
  request.has_tls = tls.has_value();
  request.is_to_redirect = shared.has_tls && !tls;
  if (!shared.proxies.trusts(peer)) {  // the address is that of the peer, as run() has set it
    client = address;
    return;
  }
  const ProxyFields& fields = shared.proxies.fields();
  const bool is_rfc_7239 = fields.client == ClientField::forwarded;
  const TrustedProxies::Client found =
      shared.proxies.client_of(peer, parser.list(is_rfc_7239 ? "Forwarded" : "X-Forwarded-For"),
                               parser.list("X-Forwarded-Proto"));
  request.has_tls = request.has_tls || found.has_tls;
  if (!fields.user.empty()) request.user = parser.single(fields.user);
  groups = fields.groups.empty() ? std::string() : parser.list(fields.groups);
  request.groups = groups;
  address = found.address.client_key();
  client = address;
}

/// Sends what the system takes at once of both spans, and removes it from them: of a small response
/// all, in one call of the system. Only once in a response, and not more than kPieceBytes, so that
/// a fast client does not keep the thread from the others. Returns false if the connection is
/// broken. Not a coroutine, which would need a frame.
bool Connection::State::send_at_once(Bytes& first, Bytes& second) {
  if (tls) return true;
  const Bytes slice = second.first(std::min(second.size(), kPieceBytes));
  error_code error;
  const size_t sent = socket.write_some(buffers_of(first, slice), error);
  if (error && error != asio::error::would_block) return false;
  const size_t of_first = std::min(sent, first.size());
  first = first.subspan(of_first);
  second = second.subspan(sent - of_first);
  body_bytes += sent - of_first;
  return true;
}

/// Writes both spans, in slices of kPieceBytes. The client must receive each within write_time.
Awaitable<bool> Connection::State::write(Bytes first, Bytes second) {
  while (!first.empty() || !second.empty()) {
    const Bytes slice = second.first(std::min(second.size(), kPieceBytes));
    const auto buffers = buffers_of(first, slice);
    if (place.state() == OpenConnection::State::serving) set_state(OpenConnection::State::sending);
    expires_after(shared.limits.write_time);
    is_writing = true;
    std::tuple<error_code, size_t> result;
    if (tls) {
      result = co_await asio::async_write(*tls, buffers, kAwait);
    } else {
      result = co_await asio::async_write(socket, buffers, kAwait);
    }
    is_writing = false;
    deadline = kNever;
    if (std::get<error_code>(result)) co_return false;
    first = {};
    second = second.subspan(slice.size());
    body_bytes += slice.size();
  }
  co_return true;
}

/// `piece`: the first of the response's stream, if it has one.
Awaitable<bool> Connection::State::write_response(Response& response, Piece& piece, bool close,
                                                  bool http_1_0, bool head) {
  body_bytes = 0;
  const std::string header = response_header(response, close, http_1_0);
  if (head) response.stream.reset();  // its memory is not within the budget
  Bytes unsent = std::as_bytes(std::span(header));
  Bytes body;
  if (!head) body = response.stream ? Bytes(piece.bytes) : body_of(response);
  if (!send_at_once(unsent, body)) co_return false;
  if (!unsent.empty() || !body.empty()) {
    if (!co_await write(unsent, body)) co_return false;
  }
  if (!response.stream || response.body_size() == 0) co_return true;
  while (true) {
    if (piece.step != BodyStream::Step::more) break;
    piece.clear();
    if (!read_in_memory(response, piece)) {
      set_state(OpenConnection::State::serving);
      co_await read_elsewhere(response, piece);
    }
    if (!co_await write({}, piece.bytes)) co_return false;
  }
  if (piece.step == BodyStream::Step::last) co_return true;
  if (!piece.error.message.empty()) report_fault(piece.error.message);
  co_return false;
}

/// Reads for up to 2 s after the last response. Closing a socket with unread bytes would reset the
/// connection, and the client could lose the response.
Awaitable<void> Connection::State::linger() {
  constexpr auto kMaxTime = std::chrono::seconds(2);
  constexpr size_t kMaxBytes = 256 * 1024;
  set_state(OpenConnection::State::sending);
  expires_after(std::min<Clock::duration>(kMaxTime, shared.limits.write_time));
  if (tls) {
    // Sends close_notify, and waits for the client's.
    co_await tls->async_shutdown(kAwait);
    co_return;
  }
  error_code failed;
  socket.shutdown(tcp::socket::shutdown_send, failed);
  if (failed) co_return;
  std::array<std::byte, 4096> unread;
  for (size_t total = 0; total < kMaxBytes;) {
    const auto [error, bytes] = co_await socket.async_read_some(asio::buffer(unread), kAwait);
    if (error) co_return;
    total += bytes;
  }
}

/// Waits until the client has taken what was sent, as long as it does. The system would hold it
/// without any limit.
Awaitable<void> Connection::State::drain() {
  const auto has_taken_all = [this] {
    return !socket.is_open() || unacknowledged_bytes(socket.native_handle()) == 0;
  };
  if (has_taken_all()) co_return;
  set_state(OpenConnection::State::sending);
  expires_after(shared.limits.write_time);
  late_bytes = acknowledged_bytes(socket.native_handle());
  Timer pause(socket.get_executor());
  do {
    pause.expires_after(std::chrono::milliseconds(50));
    co_await pause.async_wait(kAwait);
  } while (!has_taken_all());
}

void Connection::State::write_access_log(const RequestParser& parser, const Request& request,
                                         const Response& response, std::string_view id,
                                         Clock::duration duration) {
  if (!shared.log.has_access_log()) return;
  const AccessEntry entry{
      .time = std::chrono::system_clock::now() - duration,
      .id = id,
      .address = address,
      .client = response.client,
      .method = parser.method_text(),
      .target = request.target,
      .route = response.route ? response.route->pattern : std::string_view(),
      .is_http_1_0 = parser.is_http_1_0(),
      .status = response.status,
      .bytes = body_bytes,
      .duration = duration,
  };
  shared.log.access(access_line(entry, shared.log_format));
}

}  // namespace isosplat::server
