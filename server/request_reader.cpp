#include "server/request_reader.h"

#include <boost/asio/post.hpp>

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using Clock = ClientLink::Clock;

/// Bytes of the receive buffer that a connection without a request keeps.
constexpr size_t kIdleBytes = 1024;

}  // namespace

Awaitable<ProxyHeader> RequestReader::read_proxy_header() {
  link_.set_state(OpenConnection::State::waiting);
  link_.expires_after(limits_.request_time);
  ProxyHeader header;
  while (header.state == ProxyHeader::State::partial) {
    if (co_await link_.read_some()) break;
    header = parse_proxy_header(received(link_.received().size()));
  }
  if (header.state == ProxyHeader::State::complete) consume(header.bytes);
  co_return header;
}

void RequestReader::stop() {
  error_code ignored;
  if (is_idle_) link_.socket().cancel(ignored);
}

Awaitable<bool> RequestReader::wait() {
  const Clock::time_point now = Clock::now();
  link_.set_state(OpenConnection::State::waiting, now);
  if (link_.received().size() > 0) {
    // If a client pipelines many requests, let other connections of this thread run in between.
    co_await asio::post(kAwait);
    co_return true;
  }
  if (stopping_) co_return false;
  if (link_.received().capacity() > kIdleBytes) link_.received().shrink_to_fit();
  link_.expires_after(limits_.idle_time, now);
  is_idle_ = true;
  const error_code error = co_await link_.read_some();
  is_idle_ = false;
  co_return !error;
}

/// Looks for the end of the header, behind the bytes that earlier calls have scanned.
HeaderScan RequestReader::scan() {
  std::string_view received(static_cast<const char*>(link_.received().data().data()),
                            link_.received().size());
  // Empty lines before a request are ignored (RFC 9112, 2.2).
  while (scanned_ == 0 && received.starts_with("\r\n")) {
    link_.received().consume(2);
    received.remove_prefix(2);
  }
  if (received == "\r") return {};  // perhaps the beginning of an empty line
  HeaderScan scan = scan_header(received, scanned_, limits_.header_bytes, limits_.target_bytes);
  scanned_ = received.size();
  return scan;
}

Awaitable<HeaderScan> RequestReader::read_rest() {
  link_.expires_after(limits_.request_time);
  while (!co_await link_.read_some()) {
    HeaderScan header = scan();
    if (header.state != HeaderScan::State::partial) co_return header;
  }
  co_return HeaderScan{};
}

}  // namespace isosplat::server
