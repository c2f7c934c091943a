#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "server/client_link.h"
#include "server/connection_shared.h"
#include "server/http/message.h"
#include "server/http/streams.h"
#include "server/limits/byte_budget.h"
#include "server/limits/work_pool.h"
#include "server/net/asio.h"
#include "server/routes/routed_call.h"

namespace isosplat::server {

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

/// Makes the responses of a connection, on its thread or in the pools of threads, within the limits
/// of the client and of the memory of bodies. For the connection's thread.
class Responder {
 public:
  /// Both must outlive it.
  Responder(const ConnectionShared& shared, ClientLink& link) : shared_(shared), link_(link) {}

  /// The address of the client of the following requests, for whom they count.
  void set_address(const std::string& address) {
    address_ = address;
    client_ = address;
  }
  /// The next request counts for this address, until the router knows better.
  void begin_request() { client_ = address_; }

  const std::string& address() const { return address_; }

  /// The response to a request. One of the status 0 is not sent: the client has left. `memory`:
  /// what the response takes of the memory of bodies. `piece`: becomes the first of its stream.
  Awaitable<Response> respond(const Request& request, ByteBudget::Share& memory, Piece& piece);

  /// The response if the process cannot have more memory. `piece`: what there was of another one.
  Response refuse_for_memory(const Request& request, const Route* route, Piece& piece) const;

  /// The next bytes of a body, if they need neither a disk nor computing; `piece` is clear. Not a
  /// coroutine, which would need a frame for each piece. Returns false for read_elsewhere().
  bool read_in_memory(const Response& response, Piece& piece);

  /// The next bytes of a body that read_in_memory() cannot read.
  Awaitable<void> read_elsewhere(const Response& response, Piece& piece);

  /// Withdraws what waits in a pool for a client that has left. Call it regularly.
  void watch();

 private:
  Awaitable<Response> respond_unlimited(const Request& request);
  Awaitable<Response> respond_elsewhere(const Request& request, RoutedCall& call);
  Awaitable<Response> compute_response(const Request& request, RoutedCall& call);
  Awaitable<void> compute_piece(BodyStream& body, Piece& piece);
  template <class Task>
  Awaitable<WorkPool::Outcome> run_in(WorkPool& pool, WorkPool::Kind kind, Task& task);
  bool has_left(const WorkPool& pool);
  std::optional<Response> admit_client(const std::string& name);

  // Responses that the router has not made.
  Response refuse_for_now(const Request& request, const Route* route,
                          WorkPool::Outcome outcome) const;
  Response error_of(const Piece& piece, const Request& request, const Route* route) const;
  void add_fields(const Request& request, Response& response) const {
    response.set("X-Content-Type-Options", "nosniff");
    shared_.router.policy().add_fields(request, response);
  }

  const ConnectionShared& shared_;
  ClientLink& link_;
  std::string address_{};         ///< of the client of the present request
  std::string client_{};          ///< whom it counts for: its token, or its address
  WorkPool* pool_ = nullptr;      ///< in which `job_` is
  WorkPool::Job* job_ = nullptr;  ///< what it waits for; null: nothing
};

}  // namespace isosplat::server
