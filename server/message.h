#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/status.h"

namespace isosplat {

enum class Method : uint8_t { get, head, options, other };

/// What the router needs of a request. Fields that were not sent are empty. The views live as long
/// as the request is being answered.
struct Request {
  Method method = Method::other;
  std::string_view target;
  std::string_view accept_encoding;
  std::string_view if_match;
  std::string_view if_none_match;
  std::string_view if_range;
  std::string_view range;
};

/// A body too large to hold: its bytes are made while they are sent.
class BodyStream {
 public:
  virtual ~BodyStream() = default;

  /// Of the whole body: sent as Content-Length before the first byte is made.
  virtual uint64_t size() const = 0;

  enum class Step {
    more,   ///< call again when this has been sent
    last,   ///< the body is complete
    broken  ///< send this, then close the connection: the rest cannot be made
  };

  /// Appends the next bytes, at least one unless broken. `error` says why where broken.
  virtual Step next(std::vector<std::byte>& out, Error& error) = 0;
};

/// An answer. Nothing that a client sent goes into `headers`.
struct Response {
  int status = 200;
  std::string headers;  ///< fields, each ended by CR LF; not Content-Length, Date, Connection
  std::string text;     ///< the body, unless `bytes` or `stream` is given
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> owner;  ///< keeps `bytes`
  std::unique_ptr<BodyStream> stream;
  bool close = false;  ///< the connection after it
  std::string fault;   ///< for the log: what went wrong here, as opposed to at the client

  uint64_t body_size() const {
    if (stream) return stream->size();
    return bytes.data() != nullptr ? bytes.size() : text.size();
  }

  void set(std::string_view name, std::string_view value) {
    headers += name;
    headers += ": ";
    headers += value;
    headers += "\r\n";
  }
};

/// The reason phrase of each status code that the server uses.
std::string_view reason_phrase(int status);

/// `text` as a JSON string with its quotes; bytes that are not UTF-8 become U+FFFD.
std::string json_string(std::string_view text);

/// An answer {"status": name, "message": message} that is not to be stored.
Response error_response(int status, std::string_view name, std::string_view message);

/// The same for an error of the core, under the HTTP status that stands for its cause: 400
/// invalid_argument, 404 not_found, else 500, which is also a fault.
Response error_response(const Error& error);

}  // namespace isosplat
