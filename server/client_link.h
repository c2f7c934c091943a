#pragma once

#include <algorithm>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/system/error_code.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "server/limits/admission.h"
#include "server/net/asio.h"
#include "server/net/tls.h"
#include "server/server.h"

namespace isosplat::server {

/// The socket of a connection, with TLS or without. Reads and writes bytes, and closes the
/// connection if the client exceeds a time limit. For the socket's thread.
class ClientLink {
 public:
  using Clock = std::chrono::steady_clock;
  using Bytes = std::span<const std::byte>;
  using State = OpenConnection::State;

  /// `tls`: null without TLS. `limits` and `slot` must outlive it.
  ClientLink(Socket socket, std::shared_ptr<TlsContext> tls, const ServerLimits& limits,
             OpenConnection& slot)
      : socket_(std::move(socket)),
        tls_context_(std::move(tls)),
        limits_(limits),
        admission_slot_(slot),
        // the largest header, and one more read
        buffer_(limits.header_bytes + 8192) {}

  Socket& socket() { return socket_; }
  OpenConnection& slot() { return admission_slot_; }
  bool is_open() const { return socket_.is_open(); }
  bool needs_tls() const { return tls_context_ != nullptr; }  ///< call shake_hands() first
  bool has_tls() const { return tls_.has_value(); }

  /// The bytes that were received and not yet consumed.
  boost::beast::flat_buffer& received() { return buffer_; }

  /// Number of bytes of the last response's body that were sent.
  uint64_t body_bytes() const { return body_bytes_; }
  void begin_response() { body_bytes_ = 0; }

  void set_state(State state, Clock::time_point now = Clock::now()) {
    measured_at_ = kNever;
    admission_slot_.set_state(state, now);
  }

  /// Sets the time limit for the client action that the connection waits for.
  void expires_after(Clock::duration time, Clock::time_point now = Clock::now()) {
    deadline_ = std::min(now + time, end_);
    late_bytes_.reset();
  }

  /// Removes the time limit: the connection waits for no client action.
  void expires_never() { deadline_ = kNever; }

  /// Limits the remaining time of the connection, whatever it does.
  void end_after(Clock::duration time) { end_ = Clock::now() + time; }

  /// Closes the connection; pending operations fail. Drops bytes that the client has not received.
  /// Otherwise the system would keep them for as long as the client receives a few now and then.
  void close();

  /// Measures the client's receive rate, and closes the connection if it has exceeded a time limit.
  void watch(Clock::time_point now);

  /// Reads some bytes and appends them to those received; none if the connection ends.
  Awaitable<boost::system::error_code> read_some();

  // These return false if the connection must be closed.
  Awaitable<bool> shake_hands();
  bool send_at_once(Bytes& first, Bytes& second);
  Awaitable<bool> write(Bytes first, Bytes second);

  Awaitable<void> linger();
  Awaitable<void> drain();

 private:
  static constexpr Clock::time_point kNever = Clock::time_point::max();

  void measure_rate(Clock::time_point now);
  bool still_takes_bytes();

  Socket socket_;
  const std::shared_ptr<TlsContext> tls_context_;
  const ServerLimits& limits_;
  OpenConnection& admission_slot_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::asio::ssl::stream<Socket&>> tls_{};  ///< over `socket_`
  Clock::time_point deadline_ = kNever;  ///< for the client action that it waits for
  Clock::time_point end_ = kNever;       ///< of the connection, if it is refused
  bool is_writing_ = false;  ///< the client must receive a piece of the response until `deadline_`
  uint64_t body_bytes_ = 0;

  /// Bytes that the client has acknowledged: at the last measurement of its rate, and at its last
  /// time limit.
  uint64_t measured_bytes_ = 0;
  Clock::time_point measured_at_ = kNever;  ///< kNever: not yet
  std::optional<uint64_t> late_bytes_{};
};

}  // namespace isosplat::server
