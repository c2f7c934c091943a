#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/core/base/status.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat::server {

enum class Method : uint8_t { get, head, options, other };

/// The parts of a request that the router needs. Absent fields are empty. The views are valid until
/// the response is sent.
struct Request {
  Method method = Method::other;
  std::string_view target;
  std::string_view host;
  bool has_host = false;  ///< an empty Host differs from none
  std::string_view origin;
  std::string_view sec_fetch_site;
  std::string_view authorization;
  std::string_view cookie;
  std::string_view accept_encoding;
  std::string_view if_match;
  std::string_view if_none_match;
  std::string_view if_range;
  std::string_view range;
  std::string_view request_id;  ///< as sent by the client or a proxy; not validated
  /// The other end of the connection is on this machine: the client, or a proxy.
  bool is_from_this_machine = false;
  bool is_forwarded = false;  ///< whether a proxy forwarded the request, by its fields
  /// Whether the connection has TLS, or a trusted proxy states that the client's connection has it.
  bool has_tls = false;
  /// The server has TLS, but this connection came to the port that only redirects to it.
  bool is_to_redirect = false;
  // The identity of the client, as stated by a trusted proxy; empty: none.
  std::string_view user;
  std::string_view groups;  ///< separated by commas
};

/// The kinds of threads that produce responses, and the slow work that each may do.
enum class ThreadKind : uint8_t {
  connection,  ///< may neither wait for disks nor compute, since it serves other connections as
               ///< well
  disk,        ///< may wait for disks
  computing    ///< may compute
};

/// A body that is too large to keep in memory, and is therefore produced while it is sent.
class BodyStream {
 public:
  virtual ~BodyStream() = default;

  /// Size of the whole body in bytes, for Content-Length.
  virtual uint64_t size() const = 0;

  enum class Step {
    more,   ///< call next() again after these bytes are sent
    last,   ///< the body is complete
    broken  ///< send these bytes, then close the connection, since the rest cannot be produced. If
            ///< no bytes of the body were sent before, the response becomes an error instead
  };

  /// The maximum memory needed to send the body, in bytes.
  virtual uint64_t memory() const { return uint64_t{128} << 10; }

  /// Appends the next bytes to `out`, which must be empty. Appends at least one byte, with two
  /// exceptions: the stream is broken, or the first byte needs the disk and `no_wait` is given. In
  /// the latter case, call again without `no_wait` (null: may wait). Sets `error` if broken. The
  /// first call must read something before it appends bytes, since the response can become an error
  /// only until the first bytes are sent.
  virtual Step next(std::vector<std::byte>& out, Error& error, NoWait* no_wait) = 0;

  /// For bodies of routes that compute. After next() has reported that it needs the disk, reads the
  /// bytes that next() needs, and keeps them for its next call. Called on a thread that may wait
  /// for disks.
  virtual Result<void> fetch() { return {}; }
};

struct Route;

/// A response. `headers` must not contain text of a client, except a validated request id
/// (is_request_id).
struct Response {
  int status = 200;
  const Route* route = nullptr;  ///< null: the request was refused before it had one
  std::string headers;           ///< lines that end in CR LF; not Content-Length, Date, Connection
  std::string text;              ///< the body, unless `bytes` or `stream` is given
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> owner;  ///< of the memory of `bytes`
  std::unique_ptr<BodyStream> stream;
  std::string client;  ///< name of the token that admitted the client, or "link"; for the log
  bool close = false;  ///< close the connection after this response
  std::string fault;   ///< an error of the server (not of the client), for the log

  uint64_t body_size() const {
    if (stream) return stream->size();
    return bytes.data() != nullptr ? bytes.size() : text.size();
  }

  /// The memory needed to send the body, in bytes.
  uint64_t memory() const { return stream ? stream->memory() : body_size(); }

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

/// An error response with the body {"status": name, "message": message} and no-store.
Response error_response(int status, std::string_view name, std::string_view message);

/// The same for an error of the core. HTTP status: 400 for invalid_argument, 404 for not_found,
/// else 500, which is also logged as a fault.
Response error_response(const Error& error);

}  // namespace isosplat::server
