#pragma once

#include <chrono>
#include <string>

#include "native/remote/remote_target.h"
#include "native/remote/transfer.h"

namespace isosplat::remote {

struct HttpOptions {
  unsigned attempts = 6;                      ///< of each request, at least 1
  unsigned stall_s = 30;                      ///< see Transfers
  std::chrono::milliseconds first_wait{250};  ///< before the second attempt; doubles each time
};

/// Sends requests, and repeats those whose fault may pass: resets, timeouts, short bodies, and the
/// statuses 408, 429, 500, 502, 503 and 504, and bodies that arrived changed or late at S3. Waits
/// longer each time, by up to a quarter more at random, and at least as long as Retry-After says,
/// but never longer than 30 s. Several threads may send at the same time. All requests must be
/// repeatable.
class HttpClient {
 public:
  explicit HttpClient(const HttpOptions& options = {})
      : options_(options), transfers_(options.stall_s) {}

  /// The response, whatever its status is. `name`: of the object, for messages: the address without
  /// credentials. Errors: io_error, after the last attempt.
  Result<HttpResponse> send(const HttpRequest& request, const std::string& name);

 private:
  std::chrono::milliseconds wait_before(unsigned attempt, const HttpResponse* response) const;

  const HttpOptions options_;
  Transfers transfers_;
};

/// The text of the first XML element with this name, shortened. Empty if there is none.
std::string element_text(std::string_view xml, const std::string& name, size_t max_bytes);

/// The error of a response with a status that was not expected: "NAME: ACTION failed: …". Has the
/// status, the code and message of S3 if the body has them, and what to do. `action`: such as "the
/// request". Status: io_error.
Error response_error(const HttpResponse& response, const RemoteTarget& target,
                     const std::string& action);

}  // namespace isosplat::remote
