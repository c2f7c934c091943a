#include "server/client_link.h"

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <utility>

#include "server/http/streams.h"
#include "server/net/tcp_progress.h"

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using tcp = asio::ip::tcp;

/// Number of bytes to read at a time. The first read is as long as most requests are, since an idle
/// connection keeps this memory.
constexpr size_t kFirstBytes = 1024;
constexpr size_t kReadBytes = 4096;

std::array<asio::const_buffer, 2> buffers_of(ClientLink::Bytes first, ClientLink::Bytes second) {
  return {asio::const_buffer(first.data(), first.size()),
          asio::const_buffer(second.data(), second.size())};
}

}  // namespace

void ClientLink::close() {
  deadline_ = kNever;
  if (!socket_.is_open()) return;
  if (unacknowledged_bytes(socket_.native_handle()) > 0) reset_on_close(socket_.native_handle());
  error_code ignored;
  socket_.close(ignored);
}

void ClientLink::watch(Clock::time_point now) {
  if (!socket_.is_open()) return;
  if (admission_slot_.state() == State::sending) measure_rate(now);
  if (now <= deadline_) return;
  if (!is_writing_ && now <= end_ && still_takes_bytes()) {
    deadline_ = std::min(now + limits_.write_time, end_);
  } else {
    close();
  }
}

/// Completes the TLS handshake within request_time.
Awaitable<bool> ClientLink::shake_hands() {
  expires_after(limits_.request_time);
  error_code error;
  if (buffer_.size() == 0) {
    // Allocate no TLS state for a client that sends nothing.
    co_await socket_.async_wait(Socket::wait_read, await(error));
    if (error) co_return false;
  }
  tls_.emplace(socket_, *tls_context_);
  // The bytes read behind a header of the PROXY protocol begin the handshake.
  const size_t used =
      co_await tls_->async_handshake(asio::ssl::stream_base::server, buffer_.data(), await(error));
  buffer_.consume(used);
  co_return !error;
}

Awaitable<error_code> ClientLink::read_some() {
  const auto space = buffer_.prepare(buffer_.size() == 0 ? kFirstBytes : kReadBytes);
  error_code error;
  size_t bytes = 0;
  if (tls_) {
    bytes = co_await tls_->async_read_some(space, await(error));
  } else {
    bytes = co_await socket_.async_read_some(space, await(error));
  }
  if (!error) buffer_.commit(bytes);
  co_return error;
}

/// Sends as many bytes of both spans as the system accepts at once, and removes them from the
/// spans. A small response is sent completely, with one system call. Sends at most kPieceBytes, and
/// only once per response, so that a fast client does not occupy the thread. Returns false if the
/// connection is broken. This is not a coroutine, to save the allocation of a frame.
bool ClientLink::send_at_once(Bytes& first, Bytes& second) {
  if (tls_) return true;
  const Bytes slice = second.first(std::min(second.size(), kPieceBytes));
  error_code error;
  const size_t sent = socket_.write_some(buffers_of(first, slice), error);
  if (error && error != asio::error::would_block) return false;
  const size_t of_first = std::min(sent, first.size());
  first = first.subspan(of_first);
  second = second.subspan(sent - of_first);
  body_bytes_ += sent - of_first;
  return true;
}

/// Writes both spans, in slices of kPieceBytes. The client must receive each within write_time.
Awaitable<bool> ClientLink::write(Bytes first, Bytes second) {
  while (!first.empty() || !second.empty()) {
    const Bytes slice = second.first(std::min(second.size(), kPieceBytes));
    const auto buffers = buffers_of(first, slice);
    if (admission_slot_.state() == State::serving) set_state(State::sending);
    expires_after(limits_.write_time);
    is_writing_ = true;
    error_code error;
    if (tls_) {
      co_await asio::async_write(*tls_, buffers, await(error));
    } else {
      co_await asio::async_write(socket_, buffers, await(error));
    }
    is_writing_ = false;
    deadline_ = kNever;
    if (error) co_return false;
    first = {};
    second = second.subspan(slice.size());
    body_bytes_ += slice.size();
  }
  co_return true;
}

/// Reads for up to 2 s after the last response. Closing a socket with unread bytes would reset the
/// connection, and the client could lose the response.
Awaitable<void> ClientLink::linger() {
  constexpr auto kMaxTime = std::chrono::seconds(2);
  constexpr size_t kMaxBytes = 256 * 1024;
  set_state(State::sending);
  expires_after(std::min<Clock::duration>(kMaxTime, limits_.write_time));
  error_code error;
  if (tls_) {
    // Sends close_notify, and waits for the client's.
    co_await tls_->async_shutdown(await(error));
    co_return;
  }
  socket_.shutdown(tcp::socket::shutdown_send, error);
  if (error) co_return;
  std::array<std::byte, 4096> unread;
  for (size_t total = 0; total < kMaxBytes;) {
    const size_t bytes = co_await socket_.async_read_some(asio::buffer(unread), await(error));
    if (error) co_return;
    total += bytes;
  }
}

/// Waits until the client has received the sent bytes, while it makes progress. The system would
/// keep them without any time limit.
Awaitable<void> ClientLink::drain() {
  const auto has_taken_all = [this] {
    return !socket_.is_open() || unacknowledged_bytes(socket_.native_handle()) == 0;
  };
  if (has_taken_all()) co_return;
  set_state(State::sending);
  expires_after(limits_.write_time);
  late_bytes_ = acknowledged_bytes(socket_.native_handle());
  Timer pause(socket_.get_executor());
  error_code ignored;
  do {
    pause.expires_after(std::chrono::milliseconds(50));
    co_await pause.async_wait(await(ignored));
  } while (!has_taken_all());
}

/// Called twice within `patience`, while the client receives a response.
void ClientLink::measure_rate(Clock::time_point now) {
  if (measured_at_ != kNever && now - measured_at_ < limits_.patience / 2) return;
  const uint64_t bytes = acknowledged_bytes(socket_.native_handle());
  if (measured_at_ != kNever) {
    const double seconds = std::chrono::duration<double>(now - measured_at_).count();
    admission_slot_.set_rate(
        static_cast<uint64_t>(static_cast<double>(bytes - measured_bytes_) / seconds));
  }
  measured_bytes_ = bytes;
  measured_at_ = now;
}

/// For a client that is late with its next request: returns whether it is still receiving a
/// response, and has received a piece of it since the last call.
bool ClientLink::still_takes_bytes() {
  if (unacknowledged_bytes(socket_.native_handle()) == 0) return false;
  const uint64_t bytes = acknowledged_bytes(socket_.native_handle());
  const bool is_receiving = !late_bytes_ || bytes - *late_bytes_ >= kPieceBytes;
  late_bytes_ = bytes;
  return is_receiving;
}

}  // namespace isosplat::server
