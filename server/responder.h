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

/// A piece of a body that is produced while it is sent.
struct Piece {
  std::vector<std::byte> bytes;
  BodyStream::Step step = BodyStream::Step::more;
  Error error;  ///< if broken; if it has no message, see `outcome`
  WorkPool::Outcome outcome = WorkPool::Outcome::done;

  void clear() {
    bytes.clear();
    step = BodyStream::Step::more;
  }
};

/// Computes the responses of a connection, on its thread or in the thread pools, within the limits
/// of the client and of the memory for bodies. For the connection's thread.
class Responder {
 public:
  /// Both must outlive it.
  Responder(const ConnectionShared& shared, ClientLink& link) : shared_(shared), link_(link) {}

  /// Sets the address of the client of the following requests.
  void set_address(const std::string& address) {
    address_ = address;
    client_ = address;
  }
  /// Counts the next request for this address, until the router has identified its client.
  void begin_request() { client_ = address_; }

  const std::string& address() const { return address_; }

  /// The response to a request. A response of status 0 is not sent, since the client has
  /// disconnected. `memory`: receives the response's share of the memory for bodies. `piece`:
  /// receives the first piece of the response's stream.
  Awaitable<Response> respond(const Request& request, ByteBudget::Share& memory, Piece& piece);

  /// The response if the process cannot allocate memory. `piece`: the piece of an abandoned
  /// response, which is cleared.
  Response refuse_for_memory(const Request& request, const Route* route, Piece& piece) const;

  /// Reads the next bytes of a body if they need neither a disk nor computing; `piece` must be
  /// empty. Returns false if read_elsewhere() must read them. This is not a coroutine, to save the
  /// allocation of a frame for each piece.
  bool read_in_memory(const Response& response, Piece& piece);

  /// Reads the next bytes of a body that read_in_memory() cannot read.
  Awaitable<void> read_elsewhere(const Response& response, Piece& piece);

  /// Withdraws the jobs of a client that has disconnected. Call it regularly.
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

  // Responses to requests that the router has not answered.
  Response refuse_for_now(const Request& request, const Route* route,
                          WorkPool::Outcome outcome) const;
  Response error_of(const Piece& piece, const Request& request, const Route* route) const;
  void add_fields(const Request& request, Response& response) const {
    response.set("X-Content-Type-Options", "nosniff");
    shared_.router.policy().add_fields(request, response);
  }

  const ConnectionShared& shared_;
  ClientLink& link_;
  std::string address_{};  ///< of the client of the current request
  std::string client_{};   ///< the client that it counts for: the name of its token, or its address
  WorkPool* pool_ = nullptr;      ///< the pool with `job_`
  WorkPool::Job* job_ = nullptr;  ///< the job that the connection waits for; null: none
};

}  // namespace isosplat::server
