#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "server/http/message.h"

namespace isosplat::server {

/// The position of the end of a request's header in the bytes received so far.
struct HeaderScan {
  enum class State {
    partial,   ///< more bytes are needed
    complete,  ///< the header is the first `bytes` bytes
    refused    ///< not a valid header: send `refusal`
  };
  State state = State::partial;
  size_t bytes = 0;
  std::optional<Response> refusal;
};

/// Looks for the end of the header in `received`, which must not begin with a line break.
/// `scanned`: the number of bytes that an earlier call with the result `partial` has scanned.
///
/// The size limit is checked here, because Beast 1.81 applies its limit to each piece of input
/// separately, so that a header of many small fields is not limited. A line feed without carriage
/// return is refused, because servers and proxies interpret it differently.
HeaderScan scan_header(std::string_view received, size_t scanned, size_t max_bytes,
                       size_t max_target_bytes);

/// Parses the header of one request. Refuses headers that Beast accepts but that would allow
/// request smuggling: two programs could disagree about the end of the request.
class RequestParser {
 public:
  RequestParser();
  ~RequestParser();
  RequestParser(const RequestParser&) = delete;
  RequestParser& operator=(const RequestParser&) = delete;

  /// Parses a header that scan_header() found complete. If the request is refused, returns a
  /// response, which closes the connection. Call once.
  std::optional<Response> parse(std::string_view header);

  // Call after parse(). Fields that were not parsed are empty. The views refer to this object.
  Request request() const;
  std::string_view method_text() const;

  /// The value of the field of this name; empty if there is none, or several.
  std::string_view single(std::string_view name) const;

  /// The values of all fields of this name, in their order, joined by ", ".
  std::string list(std::string_view name) const;
  bool keep_alive() const;
  bool is_http_1_0() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isosplat::server
