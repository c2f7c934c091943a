#include "server/connection.h"

#include <netinet/tcp.h>

#include <new>
#include <span>
#include <utility>

#include "server/access/ip_address.h"
#include "server/client_link.h"
#include "server/http/request_parser.h"
#include "server/http/response_header.h"
#include "server/http/streams.h"
#include "server/limits/memory_limit.h"
#include "server/request_reader.h"
#include "server/responder.h"
#include "server/routes/refusals.h"

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using tcp = asio::ip::tcp;

using Bytes = ClientLink::Bytes;
using Clock = ClientLink::Clock;

/// The largest number of unsent bytes that the system keeps for a slow client (TCP_NOTSENT_LOWAT).
/// Without this option, the system keeps megabytes. Bytes in transit to a fast client do not count.
using UnsentBytes = asio::detail::socket_option::integer<IPPROTO_TCP, TCP_NOTSENT_LOWAT>;

/// Bytes that the process must be able to allocate for any request (has_memory_for), in addition to
/// the body.
constexpr uint64_t kRequestBytes = 1 << 20;

/// The body of a response without a stream.
Bytes body_of(const Response& response) {
  return response.bytes.data() != nullptr ? response.bytes
                                          : std::as_bytes(std::span(response.text));
}

}  // namespace

struct Connection::State {
  State(Socket socket, std::shared_ptr<TlsContext> tls, const ConnectionShared& of_server,
        OpenConnection& slot)
      : shared(of_server), link(std::move(socket), std::move(tls), of_server.limits, slot) {}

  Awaitable<bool> handle_request();
  void identify_client(const RequestParser& parser, Request& request);
  Awaitable<bool> write_response(Response& response, Piece& piece, bool close, bool http_1_0,
                                 bool head);
  void write_access_log(const RequestParser& parser, const Request& request,
                        const Response& response, std::string_view id, Clock::duration duration);
  void record_refusal(int status);
  void report_fault(std::string_view message) {
    ++shared.metrics.faults;
    shared.log.fault(message);
  }

  const ConnectionShared& shared;
  ClientLink link;
  RequestReader reader{link, shared.limits, shared.stopping};
  Responder responder{shared, link};
  IpAddress peer{};       ///< the other end, or the client named by a header of the PROXY protocol
  bool is_local = false;  ///< the peer is on this machine
  std::string groups{};   ///< of the client of the current request, as stated by a trusted proxy
};

Connection::Connection(Socket socket, std::shared_ptr<TlsContext> tls,
                       const ConnectionShared& shared, OpenConnection& slot)
    : state_(new State(std::move(socket), std::move(tls), shared, slot)) {
  error_code error;
  Socket& own = state_->link.socket();
  const tcp::endpoint peer = own.remote_endpoint(error);
  state_->peer = IpAddress::of(*peer.data()).value_or(IpAddress{});
  state_->is_local = state_->peer.is_loopback() && !error;
  own.non_blocking(true, error);
}

Connection::~Connection() = default;

void Connection::stop() {
  state_->reader.stop();
}

void Connection::abort() {
  state_->link.close();
}

bool Connection::close_for_another(OpenConnection::State chosen) {
  OpenConnection& slot = state_->link.slot();
  const bool is_as_chosen = slot.state() == chosen;
  if (is_as_chosen) {
    state_->link.close();
  } else {
    slot.keep();
  }
  return is_as_chosen;
}

void Connection::watch(std::chrono::steady_clock::time_point now) {
  state_->responder.watch();
  state_->link.watch(now);
}

Awaitable<void> Connection::run(std::unique_ptr<Response> refusal) {
  State& state = *state_;
  ClientLink& link = state.link;
  error_code ignored;
  state.responder.set_address(state.peer.client_key());
  link.socket().set_option(tcp::no_delay(true), ignored);
  link.socket().set_option(UnsentBytes(2 * kPieceBytes), ignored);
  if (refusal) link.end_after(state.shared.limits.refusal_time);
  link.set_state(OpenConnection::State::waiting);
  if (link.needs_tls() && !co_await link.shake_hands()) {
    ++state.shared.metrics.tls_failures;
    if (refusal) state.record_refusal(0);
    link.close();
    co_return;
  }
  if (refusal) {
    Piece none;
    const bool sent = co_await state.write_response(*refusal, none, true, false, false);
    state.record_refusal(refusal->status);
    if (sent) co_await link.linger();
  } else {
    // Two statements: g++ 12 evaluates both sides of "co_await a && co_await b" in any case.
    try {
      for (bool is_open = true; is_open;) {
        is_open = co_await state.reader.wait();
        if (is_open) is_open = co_await state.handle_request();
      }
    } catch (const std::bad_alloc&) {
      ++state.shared.metrics.out_of_memory;
      link.close();
      co_return;
    }
  }
  co_await link.drain();
  link.close();
}

bool Connection::has_proxy_header() const {
  return state_->shared.proxies.send_proxy_header(state_->peer);
}

Awaitable<std::optional<std::string>> Connection::read_proxy_header() {
  State& state = *state_;
  const ProxyHeader header = co_await state.reader.read_proxy_header();
  if (header.state != ProxyHeader::State::complete) {
    state.link.close();
    co_return std::nullopt;
  }
  if (header.source) state.peer = *header.source;
  // If the proxy does not know its client, the client may be on any machine.
  state.is_local = state.peer.is_loopback() && (header.source || header.is_local);
  co_return state.peer.client_key();
}

/// Serves a request whose first bytes have arrived. Returns false if the connection must be closed.
Awaitable<bool> Connection::State::handle_request() {
  HeaderScan header = reader.scan_first();
  if (header.state == HeaderScan::State::partial) header = co_await reader.read_rest();
  const Clock::time_point begin = Clock::now();
  link.set_state(OpenConnection::State::serving, begin);
  link.expires_never();
  if (header.state == HeaderScan::State::partial) co_return false;
  RequestParser parser;
  std::optional<Response> refusal = std::move(header.refusal);
  if (!refusal) {
    refusal = parser.parse(reader.received(header.bytes));
    reader.consume(header.bytes);
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
      if (has_memory) response = co_await responder.respond(request, memory, piece);
    } catch (const std::bad_alloc&) {
      has_memory = false;
    }
    if (!has_memory) response = responder.refuse_for_memory(request, response.route, piece);
  }
  if (!response.fault.empty()) report_fault(response.fault);

  std::string id;
  const bool has_id = is_request_id(request.request_id);
  if (has_id || shared.log.has_access_log()) id = request_id(request.request_id);
  if (has_id) response.set("X-Request-Id", id);
  const bool close = response.close || !parser.keep_alive() || shared.stopping;
  bool sent = false;
  link.begin_response();
  if (response.status != 0) {
    sent = co_await write_response(response, piece, close, parser.is_http_1_0(),
                                   request.method == Method::head);
  }
  const Clock::duration duration = Clock::now() - begin;
  shared.metrics.add_response(response.route ? index_of(*response.route) : Metrics::kNoRoute,
                              response.status, link.body_bytes(), duration);
  write_access_log(parser, request, response, id, duration);
  if (!sent) co_return false;
  if (close) co_await link.linger();
  co_return !close;
}

/// Sets the responder's address and the request's origin: those of the client named by a trusted
/// proxy, or else of the peer.
void Connection::State::identify_client(const RequestParser& parser, Request& request) {
  request.is_from_this_machine = is_local;
  request.has_tls = link.has_tls();
  request.is_to_redirect = shared.has_tls && !link.has_tls();
  if (!shared.proxies.trusts(peer)) {
    responder.begin_request();  // of the peer
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
  responder.set_address(found.address.client_key());
}

/// `piece`: the first piece of the response's stream, if it has one.
Awaitable<bool> Connection::State::write_response(Response& response, Piece& piece, bool close,
                                                  bool http_1_0, bool head) {
  link.begin_response();
  const std::string header = response_header(response, close, http_1_0);
  if (head) response.stream.reset();  // the budget does not include its memory
  Bytes unsent = std::as_bytes(std::span(header));
  Bytes body;
  if (!head) body = response.stream ? Bytes(piece.bytes) : body_of(response);
  if (!link.send_at_once(unsent, body)) co_return false;
  if (!unsent.empty() || !body.empty()) {
    if (!co_await link.write(unsent, body)) co_return false;
  }
  if (!response.stream || response.body_size() == 0) co_return true;
  while (true) {
    if (piece.step != BodyStream::Step::more) break;
    piece.clear();
    if (!responder.read_in_memory(response, piece)) {
      link.set_state(OpenConnection::State::serving);
      co_await responder.read_elsewhere(response, piece);
    }
    if (!co_await link.write({}, piece.bytes)) co_return false;
  }
  if (piece.step == BodyStream::Step::last) co_return true;
  if (!piece.error.message.empty()) report_fault(piece.error.message);
  co_return false;
}

void Connection::State::write_access_log(const RequestParser& parser, const Request& request,
                                         const Response& response, std::string_view id,
                                         Clock::duration duration) {
  if (!shared.log.has_access_log()) return;
  const AccessEntry entry{
      .time = std::chrono::system_clock::now() - duration,
      .id = id,
      .address = responder.address(),
      .client = response.client,
      .method = parser.method_text(),
      .target = request.target,
      .route = response.route ? response.route->pattern : std::string_view(),
      .is_http_1_0 = parser.is_http_1_0(),
      .status = response.status,
      .bytes = link.body_bytes(),
      .duration = duration,
  };
  shared.log.access(access_line(entry, shared.log_format));
}

/// Counts and logs a connection that was closed before its request was read. `status`: 0 without a
/// response.
void Connection::State::record_refusal(int status) {
  shared.metrics.add_response(Metrics::kNoRoute, status, link.body_bytes(), {});
  if (!shared.log.has_access_log()) return;
  shared.log.access(
      refusal_line(shared.log_format, responder.address(), status, link.body_bytes()));
}

}  // namespace isosplat::server
