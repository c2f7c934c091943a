#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "shared/core/base/status.h"

namespace isosplat::remote {

/// The key with which libcurl signs a request (AWS Signature Version 4 of the service "s3").
struct AwsSignature {
  std::string region;
  std::string access_key, secret_key;
  std::string session_token;  ///< of temporary credentials; may be empty
};

struct HttpRequest {
  std::string method = "GET";
  std::string url;                        ///< http://… or https://…
  std::vector<std::string> headers;       ///< "Name: value"
  std::span<const std::byte> body;        ///< must live until the request has ended
  uint64_t max_bytes = 0;                 ///< of the response's body, if its status is 200 to 299
  uint64_t max_range_bytes = UINT64_MAX;  ///< the same for status 206, if less
  std::shared_ptr<const AwsSignature> signature;  ///< null: not signed
  unsigned attempts = 0;                          ///< at least; see HttpOptions
  unsigned stall_s = 0;                           ///< at least; see Transfers
};

struct HttpResponse {
  int status = 0;
  /// Those that this program uses (kHeaders in transfer.cpp), by their names in lower case; of the
  /// last response if there were redirects.
  std::map<std::string, std::string, std::less<>> headers;
  std::vector<std::byte> body;
  bool is_cut = false;  ///< the body was longer than max_bytes: its rest was not read

  /// Empty if there is no such header.
  std::string header(std::string_view name) const {
    const auto found = headers.find(name);
    return found == headers.end() ? std::string() : found->second;
  }
  std::string_view text() const {
    return {reinterpret_cast<const char*>(body.data()), body.size()};
  }
};

/// Why a transfer has failed before its response was complete.
struct TransferFault {
  std::string message;
  bool may_pass = false;  ///< a repetition may succeed: a reset, a timeout, a short body
};

/// Sends single requests by libcurl, without repetition. Keeps connections for further requests.
/// Several threads may send at the same time, each through a connection of its own.
///
/// Follows redirects of requests that are not signed, never from https to http. Proxies are those
/// of the environment (https_proxy, no_proxy, …); SSL_CERT_FILE names other certificates to trust
/// than those of the system. The memory for a response grows with the bytes that arrive, up to
/// max_bytes, whatever length the server states.
class Transfers {
 public:
  /// stall_s: a transfer of fewer than 1000 bytes per second for this time has failed; also the
  /// limit of connecting.
  explicit Transfers(unsigned stall_s) : stall_s_(stall_s) {}
  ~Transfers();
  Transfers(const Transfers&) = delete;

  tl::expected<HttpResponse, TransferFault> send(const HttpRequest& request);

 private:
  void* take_handle();

  const unsigned stall_s_;
  std::mutex mutex_;
  std::vector<void*> idle_;  // CURL handles with open connections
};

}  // namespace isosplat::remote
