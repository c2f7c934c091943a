#pragma once

#include <atomic>
#include <cstddef>
#include <string_view>

#include "server/access/proxy_header.h"
#include "server/client_link.h"
#include "server/http/request_parser.h"
#include "server/net/asio.h"
#include "server/server.h"

namespace isosplat::server {

/// Reads the headers of a connection's requests, within the time limits.
class RequestReader {
 public:
  /// All must outlive it. `stopping`: once set, the reader waits for no further requests.
  RequestReader(ClientLink& link, const ServerLimits& limits, const std::atomic<bool>& stopping)
      : link_(link), limits_(limits), stopping_(stopping) {}

  /// Reads the header of the PROXY protocol, the first bytes of a connection. Its state is not
  /// `complete` if the connection must be closed.
  Awaitable<ProxyHeader> read_proxy_header();

  /// Waits for the first byte of a request, up to idle_time. Returns false if the connection must
  /// be closed.
  Awaitable<bool> wait();

  /// Ends wait().
  void stop();

  /// Looks for the end of a request's header in the received bytes. Call it once wait() has
  /// returned, and read_rest() after it if the header is partial.
  HeaderScan scan_first() {
    scanned_ = 0;
    return scan();
  }

  /// Reads the rest of a request's header within request_time. Returns the state partial if the
  /// connection ends before the header is complete.
  Awaitable<HeaderScan> read_rest();

  /// The next `bytes` received bytes.
  std::string_view received(size_t bytes) const {
    return {static_cast<const char*>(link_.received().data().data()), bytes};
  }
  void consume(size_t bytes) { link_.received().consume(bytes); }

 private:
  HeaderScan scan();

  ClientLink& link_;
  const ServerLimits& limits_;
  const std::atomic<bool>& stopping_;
  bool is_idle_ = false;  ///< it waits for a request
  size_t scanned_ = 0;    ///< of the current request
};

}  // namespace isosplat::server
