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

/// Limits of a server's memory and time, so that hostile clients cannot exhaust them. The numbers
/// behind the colons are the HTTP status of a request beyond the limit (HTTP.md).
struct ServerLimits {
  size_t header_bytes = 16 * 1024;  ///< request line and header fields together: 431
  size_t target_bytes = 8 * 1024;   ///< the request's target: 414
  /// Open connections. Beyond this limit, connections that make little progress are closed
  /// (Admission); if there are none, 503. The limit is lower if the system allows fewer open files.
  uint32_t connections = 1024;
  /// Open connections from one address (IPv6: one /64 network): 429. 0: no limit. Those of a
  /// trusted proxy are not limited.
  uint32_t connections_per_address = 256;
  /// Bytes per second. If the server is full, it closes clients that have received a response more
  /// slowly than this for `patience`, to admit new connections.
  uint64_t least_rate = 16 * 1024;
  std::chrono::milliseconds patience{2'000};
  uint64_t query_bytes = uint64_t{64} << 20;  ///< of chunks in one response: 413
  uint32_t query_chunks = 65536;              ///< in one response: 413
  /// of directory pages that a query needs: 413
  uint64_t query_directory_bytes = uint64_t{256} << 20;
  uint64_t directory_bytes = uint64_t{64} << 20;       ///< cache of directory pages, per store
  uint64_t all_directory_bytes = uint64_t{512} << 20;  ///< the same of all stores
  /// Stores that stay open, at most a quarter of the files that the system allows.
  uint32_t open_stores = 256;
  uint64_t page_asset_bytes = uint64_t{64} << 20;  ///< of files below web_root, in memory
  /// Memory for bodies that are being sent: 503. One address gets at most a quarter of it, unless
  /// connections_per_address is 0.
  uint64_t bytes_in_flight = uint64_t{256} << 20;
  /// Requests that wait for a computing thread, per such thread: 503. If the queue is full, a
  /// client with fewer requests displaces the last one of the client with the most.
  uint32_t waiting_computations = 64;
  uint32_t waiting_computations_of_one = 16;  ///< the same, of one client
  // Average rates of each client: 429. 0: no limit. A client is a token or an identity, or else an
  // address (IPv6: one /64 network). See RateLimit.
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
  /// Listening TCP sockets to use instead of `host` and `port`; the server closes them.
  std::vector<int> sockets;
  std::vector<int> redirecting_sockets;  ///< the same in place of `http_port`
  /// Files of stores and scenes (is_scene_file), and folders. Of a folder, the server serves all
  /// *.isosplat files and all scenes, including those in subfolders, and notices changes; if the
  /// system does not report them, it scans the folder every scan_interval. A store is opened at the
  /// first request for it. A store that cannot be opened is listed with its error.
  std::vector<std::filesystem::path> stores;
  /// Whether links to stores outside of the folders above are followed. If not, they are not
  /// served.
  bool follow_outside_links = true;
  /// Pages of other origins that may read the data. If absent, no such pages; this requires a
  /// `host` on the loopback interface. On other interfaces, either this or `is_public` must be set.
  std::optional<CrossOrigin> cross_origin;
  /// Names that requests may give as their Host, in addition to `host` and those of the loopback
  /// interface; "*": any. On other interfaces, IP addresses and the name of this machine are
  /// allowed as well.
  std::vector<std::string> allowed_hosts;
  bool is_public = false;  ///< any host, and pages of any origin
  /// Addresses of trusted proxies, in the notation of AddressRange::parse(). For limits, rates and
  /// logs, the server uses the client's address and identity that these proxies state in
  /// `proxy_fields`, and ignores those that other peers state.
  std::vector<std::string> trusted_proxies;
  ProxyFields proxy_fields;

  // TLS, with both of these PEM files: the certificate with its chain, and its private key.
  std::filesystem::path tls_certificate;
  std::filesystem::path tls_key;
  /// With TLS: also listens on this port of `host`, and redirects its requests to https.
  std::optional<uint16_t> http_port;
  uint16_t https_port = 0;    ///< in these redirections; 0: the port that the server listens on
  uint64_t hsts_seconds = 0;  ///< HttpsPolicy::hsts_seconds

  // Access (AccessRules). If any of these is set, clients need a right to read a volume.
  std::vector<std::string> tokens;           ///< each grants access to all volumes
  std::filesystem::path token_file;          ///< AccessRules::add_lines; empty: none
  std::string link_key;                      ///< of signed links; empty: no links
  std::filesystem::path link_key_file;       ///< the same in a file; empty: none
  std::filesystem::path revoked_links_file;  ///< AccessRules::add_revoked_links; empty: none
  /// The keys for tokens of an identity provider: a file, or a URL (https://…), which is fetched at
  /// the start, every five minutes and on reload(); empty: none.
  std::string jwt_keys;
  JwtOptions jwt;
  /// Of the cookies; empty: "isosplat-" and the port. Servers behind one balancer share it.
  std::string cookie_name;
  std::filesystem::path web_root;  ///< the built page; empty: only the data is served
  uint32_t threads = 0;            ///< at most kMaxServerThreads; 0: one per core
  uint32_t disk_threads = 16;      ///< threads that wait for disks, 1 to kMaxServerThreads
  std::chrono::milliseconds scan_interval{1'000};
  /// SIGTERM and SIGINT call stop(); a second one closes connections. If there are files to read
  /// again, SIGHUP calls reload(). SIGUSR2 hands the sockets over to a new process (hand_over.h),
  /// and then stops. The server reports stop, reload and hand-over to systemd.
  bool handle_signals = false;
  ServerLimits limits;
  /// Called with one line (no line break) about stores, the page and faults. From any thread, one
  /// call at a time.
  std::function<void(std::string_view line)> log;
  /// The file for these lines; null: none.
  std::shared_ptr<LogFile> log_file;
  /// The file to append the access log to, one line per response; "-": the standard output; empty:
  /// none. It is opened again on SIGHUP.
  std::filesystem::path access_log_file;
  LogFormat log_format = LogFormat::plain;
  /// Called with each line of the access log. From any thread, one call at a time.
  std::function<void(std::string_view line)> access_log;
};

/// Serves stores and the page over HTTP/1.1, with or without TLS, as HTTP.md specifies. Has
/// separate threads.
class Server {
 public:
  /// Opens the stores, binds the port and starts to serve. Errors: io_error (unknown host, port in
  /// use, missing store, folder or page), invalid_argument.
  static Result<std::unique_ptr<Server>> start(ServerOptions options);

  /// Checks the files that start() and reload() would read: stores, tokens, keys, certificates.
  /// Listens on no port, and fetches nothing. Errors: those of start().
  static Result<void> check(const ServerOptions& options);

  /// Calls stop(), and waits until the server has stopped.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The port that the server listens on, even if options.port was 0.
  uint16_t port() const;

  /// The port that redirects to https; 0: none.
  uint16_t http_port() const;

  /// The URL of the page, such as "http://localhost:8080/".
  std::string url() const;

  /// A store as /v1/volumes lists it. Reads the headers of stores that have not been read yet.
  struct Volume {
    std::string name;
    std::filesystem::path path;
    std::string content;  ///< hexadecimal content id; empty if there is an error
    std::string error;    ///< message; empty if the store is served
  };
  std::vector<Volume> volumes() const;

  /// Whether there is a store or a scene. Reads no header.
  bool has_stores() const;

  /// Reads the files of tokens and keys again for the following requests, and those of TLS for the
  /// following connections; opens the access log again. If a file cannot be read, its previous
  /// content stays in effect. Thread-safe. Errors: io_error, invalid_argument.
  Result<void> reload();

  /// Stops accepting connections, closes idle ones, and gives responses in progress the time
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
