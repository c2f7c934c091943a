#include "server/responder.h"

#include <exception>
#include <new>
#include <utility>

#include "server/limits/memory_limit.h"
#include "server/net/tcp_progress.h"
#include "server/routes/refusals.h"

namespace isosplat::server {
namespace {

using Clock = std::chrono::steady_clock;

// Bytes that the process must be able to allocate for a turn of computing (has_memory_for), in
// addition to the body.
constexpr uint64_t kComputingBytes = 16 << 20;

}  // namespace

void Responder::watch() {
  if (job_ && has_left(*pool_)) pool_->withdraw(*job_);
}

// Each request is first tried on this thread: most of the time the system has the bytes in its page
// cache, and a switch to another thread would cost more than the read. If the request needs the
// disk, or much processor time, it is repeated in a pool. The few threads that compute must not
// wait for a disk: threads for disks first read the bytes that they need.

Awaitable<Response> Responder::respond_unlimited(const Request& request) {
  NoWait no_wait;
  bool is_admitted = false;
  const auto admit = [&](const std::string& name) {
    is_admitted = true;
    return admit_client(name);
  };
  RoutedCall call = shared_.router.route(request, admit);
  Response response = call.respond(ThreadKind::connection, &no_wait);
  if (!is_admitted) {
    if (auto refusal = admit_client({})) {
      response = std::move(*refusal);
      add_fields(request, response);
    }
  }
  if (!no_wait.needs_disk) {
    ++shared_.metrics.reads_in_memory;
    co_return response;
  }
  co_return co_await respond_elsewhere(request, call);
}

/// Counts the request for the client of this name from now on, or for its address if the name is
/// empty. Returns a response if the client has used up its rate.
std::optional<Response> Responder::admit_client(const std::string& name) {
  client_ = name.empty() ? address_ : "client " + name;
  link_.slot().set_client(client_);
  const auto seconds = shared_.rates.take_request(client_, Clock::now());
  if (!seconds) return std::nullopt;
  return rate_response(*seconds);
}

/// Runs the task in the pool for this client. Withdraws it if the client disconnects.
template <class Task>
Awaitable<WorkPool::Outcome> Responder::run_in(WorkPool& pool, WorkPool::Kind kind, Task& task) {
  WorkPool::Outcome outcome = WorkPool::Outcome::withdrawn;
  if (!has_left(pool)) {
    WorkPool::Job job(client_, kind, task);
    pool_ = &pool;
    job_ = &job;
    std::exception_ptr thrown;
    try {
      outcome = co_await pool.run(job);
    } catch (...) {
      thrown = std::current_exception();
    }
    job_ = nullptr;
    if (thrown) std::rethrow_exception(thrown);
  }
  if (outcome == WorkPool::Outcome::withdrawn) ++shared_.metrics.work_cancelled;
  if (outcome == WorkPool::Outcome::refused) ++shared_.metrics.computations_refused;
  co_return outcome;
}

/// Whether the client has disconnected, so that the work of the pool is of no use. For the costly
/// computation of points, a client that closes its sending side counts as disconnected, although it
/// could still read.
bool Responder::has_left(const WorkPool& pool) {
  if (!link_.is_open()) return true;
  const TcpEnd end_of_client = tcp_end(link_.socket().native_handle());
  return end_of_client == TcpEnd::reset ||
         (end_of_client == TcpEnd::ended && &pool == &shared_.computing);
}

/// The response of a handler that needs a disk or computes.
Awaitable<Response> Responder::respond_elsewhere(const Request& request, RoutedCall& call) {
  const Route* const route = call.route();
  if (route->work == RouteWork::computes) co_return co_await compute_response(request, call);
  const bool is_of_many = route->work == RouteWork::reads_headers;
  WorkPool& pool = is_of_many ? shared_.headers : shared_.disk;
  Response response;
  WorkTurn turn;
  auto repeat = [&] { response = call.respond(ThreadKind::disk, nullptr, &turn); };
  do {
    turn.is_unfinished = false;
    const auto outcome = co_await run_in(pool, WorkPool::Kind::first, repeat);
    if (outcome != WorkPool::Outcome::done) co_return refuse_for_now(request, route, outcome);
  } while (turn.is_unfinished);
  co_return response;
}

Awaitable<Response> Responder::compute_response(const Request& request, RoutedCall& call) {
  Response response;
  WorkTurn turn;
  NoWait no_wait;
  bool may_wait = false;
  auto compute = [&] {
    // Wait for the disk if the system's page cache does not keep the bytes that were read.
    response = call.respond(ThreadKind::computing, may_wait ? nullptr : &no_wait, &turn);
  };
  auto fetch = [&] { call.respond(ThreadKind::disk, nullptr, &turn); };
  auto kind = WorkPool::Kind::first;
  while (true) {
    if (!has_memory_for(kComputingBytes)) throw std::bad_alloc();
    turn.is_unfinished = false;
    auto outcome = co_await run_in(shared_.computing, kind, compute);
    kind = WorkPool::Kind::continued;
    if (outcome == WorkPool::Outcome::done && !may_wait && no_wait.needs_disk) {
      may_wait = true;
      do {
        turn.is_unfinished = false;
        outcome = co_await run_in(shared_.disk, kind, fetch);
      } while (outcome == WorkPool::Outcome::done && turn.is_unfinished);
      turn.is_unfinished = true;
    }
    if (outcome != WorkPool::Outcome::done) {
      co_return refuse_for_now(request, call.route(), outcome);
    }
    if (!turn.is_unfinished) co_return response;
  }
}

/// The response if the server is stopping or computes too much already. A response of status 0 is
/// not sent, since the client has disconnected.
Response Responder::refuse_for_now(const Request& request, const Route* route,
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

Response Responder::refuse_for_memory(const Request& request, const Route* route,
                                      Piece& piece) const {
  ++shared_.metrics.out_of_memory;
  piece = {};
  Response response = busy_response("the server has no memory left: try again in a second");
  response.route = route;
  add_fields(request, response);
  return response;
}

Awaitable<Response> Responder::respond(const Request& request, ByteBudget::Share& memory,
                                       Piece& piece) {
  Response response = co_await respond_unlimited(request);
  if (request.method == Method::head || response.status == 0) co_return response;
  if (response.stream && !has_memory_for(response.memory())) {
    co_return refuse_for_memory(request, response.route, piece);
  }
  if (memory.take(shared_.bytes_in_flight, response.memory(), client_)) {
    if (response.stream && response.body_size() > 0) {
      if (!read_in_memory(response, piece)) co_await read_elsewhere(response, piece);
      // Nothing has been sent yet: send an error, which tells the client more than a lost
      // connection.
      if (piece.step == BodyStream::Step::broken && piece.bytes.empty()) {
        response = error_of(piece, request, response.route);
      }
    }
    shared_.rates.take_bytes(client_, response.body_size(), Clock::now());
    co_return response;
  }
  response = busy_response(
      "the server is sending as much as it has memory for, to all or to this client: try again in "
      "a second");
  add_fields(request, response);
  co_return response;
}

/// The response if the first piece of a stream cannot be read.
Response Responder::error_of(const Piece& piece, const Request& request, const Route* route) const {
  if (piece.error.message.empty()) return refuse_for_now(request, route, piece.outcome);
  Response response = error_response(piece.error);
  response.route = route;
  add_fields(request, response);
  return response;
}

bool Responder::read_in_memory(const Response& response, Piece& piece) {
  if (response.route && response.route->work == RouteWork::computes) return false;
  NoWait no_wait;
  piece.step = response.stream->next(piece.bytes, piece.error, &no_wait);
  if (no_wait.needs_disk && piece.bytes.empty()) return false;
  ++shared_.metrics.reads_in_memory;
  return true;
}

Awaitable<void> Responder::read_elsewhere(const Response& response, Piece& piece) {
  BodyStream& body = *response.stream;
  if (response.route && response.route->work == RouteWork::computes) {
    co_await compute_piece(body, piece);
    co_return;
  }
  auto repeat = [&] { piece.step = body.next(piece.bytes, piece.error, nullptr); };
  piece.outcome = co_await run_in(shared_.disk, WorkPool::Kind::continued, repeat);
  if (piece.outcome != WorkPool::Outcome::done) piece.step = BodyStream::Step::broken;
}

/// Like read_elsewhere(), for a body that is computed.
Awaitable<void> Responder::compute_piece(BodyStream& body, Piece& piece) {
  constexpr auto kKind = WorkPool::Kind::continued;
  while (true) {
    NoWait no_wait;
    auto compute = [&] { piece.step = body.next(piece.bytes, piece.error, &no_wait); };
    piece.outcome = co_await run_in(shared_.computing, kKind, compute);
    const bool has_run = piece.outcome == WorkPool::Outcome::done;
    if (has_run && (!no_wait.needs_disk || !piece.bytes.empty())) co_return;
    piece.step = BodyStream::Step::broken;  // unless the task succeeds
    if (!has_run) co_return;
    Result<void> fetched;
    auto fetch = [&] { fetched = body.fetch(); };
    piece.outcome = co_await run_in(shared_.disk, kKind, fetch);
    if (!fetched) piece.error = fetched.error();
    if (piece.outcome != WorkPool::Outcome::done || !fetched) co_return;
  }
}

}  // namespace isosplat::server
