#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>

#include "server/message.h"

namespace isosplat {

/// Where a request's header ends in what has been received so far.
struct HeaderScan {
  enum class State {
    partial,   ///< more bytes are needed
    complete,  ///< the header is the first `bytes` bytes
    refused    ///< no header can begin like this: `answer` says why
  };
  State state = State::partial;
  size_t bytes = 0;
  std::optional<Response> answer;
};

/// Looks for the end of the header in `received`, which must not begin with a line break.
/// `scanned`: how much of it an earlier call has looked at, with the state partial.
///
/// The limit is kept here: Beast 1.81 counts it anew for each piece that it is given, so that a
/// header of many small fields has no bound. A line feed without its carriage return, which
/// servers and proxies read differently, is refused.
HeaderScan scan_header(std::string_view received, size_t scanned, size_t max_bytes,
                       size_t max_target_bytes);

/// One request's header. Refuses what would make it unsafe to go on with the connection: two
/// readers could see the request's end in two places. Beast alone takes those.
class RequestParser {
 public:
  RequestParser();
  ~RequestParser();
  RequestParser(const RequestParser&) = delete;
  RequestParser& operator=(const RequestParser&) = delete;

  /// `header`: complete, by scan_header. The answer where the request is refused; it closes the
  /// connection. Call once.
  std::optional<Response> parse(std::string_view header);

  // After parse(), even a refused one (then empty where nothing was read). Views into this.
  Request request() const;
  std::string_view method_text() const;
  bool keep_alive() const;
  bool is_http_1_0() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
