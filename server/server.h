#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/access/jwt.h"
#include "server/access/origin_policy.h"
#include "server/access/trusted_proxies.h"
#include "server/log/access_log.h"
#include "server/log/log_file.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// Limits of a server's memory and time, so that hostile clients cannot exhaust them. Numbers are
/// the HTTP status of a request that exceeds the limit (HTTP.md).
struct ServerLimits {
  size_t header_bytes = 16 * 1024;  ///< request line and header fields together: 431
  size_t target_bytes = 8 * 1024;   ///< the request's target: 414
  /// Open connections: above it, those that make little progress are closed (Admission); if all do
  /// well: 503. Fewer, if the system allows fewer open files.
  uint32_t connections = 1024;
  /// Open connections from one address (IPv6: one /64 network): 429. 0: no limit. Those of a
  /// trusted proxy are not limited.
  uint32_t connections_per_address = 256;
  /// Bytes per second: clients that have taken a response more slowly for `patience` are closed for
  /// new connections if the server is full.
  uint64_t least_rate = 16 * 1024;
  std::chrono::milliseconds patience{2'000};
  uint64_t query_bytes = uint64_t{64} << 20;  ///< of chunks in one response: 413
  uint32_t query_chunks = 65536;              ///< in one response: 413
  /// Of the directory pages that a query needs: 413.
  uint64_t query_directory_bytes = uint64_t{256} << 20;
  uint64_t directory_bytes = uint64_t{64} << 20;       ///< cache of directory pages, per store
  uint64_t all_directory_bytes = uint64_t{512} << 20;  ///< the same of all stores
  /// Stores that stay open, at most a quarter of the files that the system allows.
  uint32_t open_stores = 256;
  uint64_t page_asset_bytes = uint64_t{64} << 20;  ///< of files below web_root, in memory
  /// Memory of the bodies that are being sent: 503 above it. One address gets a quarter of it at
  /// most, unless connections_per_address is 0.
  uint64_t bytes_in_flight = uint64_t{256} << 20;
  /// Requests that wait for a thread that computes, for each such thread: 503 above it. Those of
  /// the client that has most give way to clients with fewer.
  uint32_t waiting_computations = 64;
  uint32_t waiting_computations_of_one = 16;  ///< the same, of one client
  // Of each client, which is a token or an identity or else an address (IPv6: one /64 network), per
  // second, on average: 429. 0: no limit. See
  // RateLimit.
  double requests_per_second = 0;
  double bytes_per_second = 0;
  std::chrono::milliseconds idle_time{30'000};     ///< without a request on an open connection
  std::chrono::milliseconds request_time{10'000};  ///< from a request's first byte to its last
  std::chrono::milliseconds write_time{30'000};   ///< for a client to take the next 64 KiB or frame
  std::chrono::milliseconds refusal_time{2'000};  ///< to refuse a connection, with TLS or without
  std::chrono::milliseconds stop_time{10'000};    ///< for responses in progress, after stop()
  /// The same, after the server has handed its sockets over to a new process.
  std::chrono::milliseconds hand_over_time{3'600'000};
};

inline constexpr uint32_t kMaxServerThreads = 1024;

struct ServerOptions {
  std::string host = "127.0.0.1";  ///< an address or a name; "0.0.0.0" or "::" for every interface
  uint16_t port = 8080;            ///< 0: any free port
  /// Listening sockets of TCP, to use in place of `host` and `port`; the server closes them.
  std::vector<int> sockets;
  std::vector<int> redirecting_sockets;  ///< the same in place of `http_port`
  /// Store files, and folders whose *.isosplat files are served, with those of their subfolders.
  /// The server follows their changes; where the system does not report them, it looks every
  /// scan_interval. A store is opened when it is first asked for. One that cannot be opened is
  /// listed with its error.
  std::vector<std::filesystem::path> stores;
  /// Whether links to stores outside of the folders above are followed. Otherwise such a link is
  /// not served.
  bool follow_outside_links = true;
  /// Pages of other origins that may read the data. Absent: none, which requires a `host` on the
  /// loopback interface. On other interfaces the choice must be made, here or by `is_public`.
  std::optional<CrossOrigin> cross_origin;
  /// Names that requests may give as their Host, besides `host` and those of the loopback
  /// interface;
  /// "*": any. On other interfaces, IP addresses and the name of this machine are allowed as well.
  std::vector<std::string> allowed_hosts;
  bool is_public = false;  ///< any host, and pages of any origin
  /// Addresses of proxies, as AddressRange::parse() takes them. What they say about their client's
  /// address and identity, in `proxy_fields`, counts for limits, rates and logs; what others say
  /// does not.
  std::vector<std::string> trusted_proxies;
  ProxyFields proxy_fields;

  // TLS, with both of these PEM files: the certificate with its chain, and its private key.
  std::filesystem::path tls_certificate;
  std::filesystem::path tls_key;
  /// With TLS: listens on this port of `host` as well, and redirects its requests to https.
  std::optional<uint16_t> http_port;
  uint16_t https_port = 0;    ///< in these redirections; 0: the port that the server listens on
  uint64_t hsts_seconds = 0;  ///< HttpsPolicy::hsts_seconds

  // Access (AccessRules). With any of these, a volume is read only by those who are admitted.
  std::vector<std::string> tokens;           ///< each admits to all volumes
  std::filesystem::path token_file;          ///< AccessRules::add_lines; empty: none
  std::string link_key;                      ///< of signed links; empty: no links
  std::filesystem::path link_key_file;       ///< the same in a file; empty: none
  std::filesystem::path revoked_links_file;  ///< AccessRules::add_revoked_links; empty: none
  /// The keys of tokens of an identity provider: a file, or an address (https://…), which is asked
  /// at the start, every five minutes and on reload(); empty: none.
  std::string jwt_keys;
  JwtOptions jwt;
  /// Of the cookies; empty: "isosplat-" and the port. Servers behind one balancer share it.
  std::string cookie_name;
  std::filesystem::path web_root;  ///< the built page; empty: only the data is served
  uint32_t threads = 0;            ///< at most kMaxServerThreads; 0: one per core
  uint32_t disk_threads = 16;      ///< that wait for disks, 1 to kMaxServerThreads
  std::chrono::milliseconds scan_interval{1'000};
  /// SIGTERM and SIGINT call stop(); a second one closes connections. If there are files to read
  /// again, SIGHUP calls reload(). SIGUSR2 hands the sockets over to a new process
  /// (hand_over.h), and then stops. systemd is told when the server stops, reloads or hands over.
  bool handle_signals = false;
  ServerLimits limits;
  /// Called with one line (no line break) about stores, the page and faults. From any thread, one
  /// call at a time.
  std::function<void(std::string_view line)> log;
  /// Where these lines are written; null: nowhere.
  std::shared_ptr<LogFile> log_file;
  /// Where the access log is appended, one line per response; "-": the standard output; empty:
  /// none. Opened again on SIGHUP.
  std::filesystem::path access_log_file;
  LogFormat log_format = LogFormat::plain;
  /// Called with each line of the access log. From any thread, one call at a time.
  std::function<void(std::string_view line)> access_log;
};

/// Serves stores and the page over HTTP/1.1, with or without TLS, as HTTP.md specifies, with its
/// own threads.
class Server {
 public:
  /// Opens the stores, binds the port and starts to serve. Errors: io_error (unknown host, port in
  /// use, missing store, folder or page), invalid_argument.
  static Result<std::unique_ptr<Server>> start(ServerOptions options);

  /// Checks what start() and reload() would read: stores, tokens, keys, certificates. Listens on no
  /// port, and fetches nothing. Errors: as of start().
  static Result<void> check(const ServerOptions& options);

  /// Calls stop(), and waits.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The port that the server listens on, also if options.port was 0.
  uint16_t port() const;

  /// The port that redirects to https; 0: none.
  uint16_t http_port() const;

  /// The URL of the page, such as "http://localhost:8080/".
  std::string url() const;

  /// A store as /v1/volumes lists it. Reads the headers that were not read yet.
  struct Volume {
    std::string name;
    std::filesystem::path path;
    std::string content;  ///< hexadecimal content id; empty if there is an error
    std::string error;    ///< message; empty if the store is served
  };
  std::vector<Volume> volumes() const;

  /// Whether there is a store. Reads no header.
  bool has_stores() const;

  /// Reads the files of tokens and keys again for the following requests, and those of TLS for the
  /// following connections; opens the access log anew. Thread-safe. If one cannot be read, its old
  /// contents stay. Errors: io_error, invalid_argument.
  Result<void> reload();

  /// Stops to accept connections, closes idle ones, and gives responses in progress
  /// limits.stop_time. Returns at once. Thread-safe; may be called more than once.
  void stop();

  /// Returns when the server has stopped, by stop() or by a signal.
  void wait();

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat::server
