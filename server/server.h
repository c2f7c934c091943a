#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/status.h"

namespace isosplat {

/// What bounds a server's memory and time, whoever its clients are. HTTP.md says what a client sees
/// when it meets one of them.
struct ServerLimits {
  size_t header_bytes = 16 * 1024;  ///< request line and header fields together: 431
  size_t target_bytes = 8 * 1024;   ///< the request's target: 414
  uint32_t connections = 1024;      ///< open at a time: 503
  /// Open at a time from one address (IPv6: one /64 network): 429. 0: no limit, for a server behind
  /// a proxy.
  uint32_t connections_per_address = 256;
  uint64_t query_bytes = uint64_t{64} << 20;  ///< of chunks in one answer: 413
  uint32_t query_chunks = 65536;              ///< in one answer: 413
  /// Of the directory pages that a query has to look through: 413.
  uint64_t query_directory_bytes = uint64_t{256} << 20;
  uint64_t directory_bytes = uint64_t{64} << 20;   ///< of directory pages held, per store
  uint64_t page_asset_bytes = uint64_t{64} << 20;  ///< of files below web_root, held in memory
  std::chrono::milliseconds idle_time{30'000};     ///< without a request on an open connection
  std::chrono::milliseconds request_time{10'000};  ///< from a request's first byte to its last
  std::chrono::milliseconds write_time{30'000};  ///< for a client to take the next 64 KiB or frame
  std::chrono::milliseconds stop_time{10'000};   ///< for answers in flight, after stop()
};

inline constexpr uint32_t kMaxServerThreads = 1024;

struct ServerOptions {
  std::string host = "127.0.0.1";  ///< an address or a name; "0.0.0.0" or "::" for every interface
  uint16_t port = 8080;            ///< 0: any free port
  /// Store files, and folders whose *.isosplat files are served. New, replaced and removed stores
  /// are noticed within scan_interval. A store that cannot be opened is listed with its error.
  std::vector<std::filesystem::path> stores;
  std::filesystem::path web_root;  ///< the built page; empty: only the data is served
  uint32_t threads = 0;            ///< at most kMaxServerThreads; 0: one a core
  std::chrono::milliseconds scan_interval{1'000};
  bool handle_signals = false;  ///< SIGTERM and SIGINT call stop(); a second one drops connections
  ServerLimits limits;
  /// Called with one line (no line break) about stores, the page and faults; from any thread, one
  /// at a time.
  std::function<void(std::string_view line)> log;
  /// Called with one line per answer: address, method, target, status, bytes, milliseconds. What
  /// clients sent is escaped. From any thread, one at a time.
  std::function<void(std::string_view line)> access_log;
};

/// Serves stores and the page over HTTP/1.1, as HTTP.md specifies, from threads of its own.
class Server {
 public:
  /// Looks for the stores, binds the port and begins to answer. Errors: io_error (host unknown,
  /// port taken, folder or page missing), invalid_argument.
  static Result<std::unique_ptr<Server>> start(ServerOptions options);

  /// Stops, and waits.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// The port that the server listens on: the one asked for, or the free one found.
  uint16_t port() const;

  /// For a person to open, e.g. "http://localhost:8080/".
  std::string url() const;

  /// A store as /v1/volumes lists it.
  struct Volume {
    std::string name;
    std::filesystem::path path;
    std::string content;  ///< hexadecimal content id; empty where there is an error
    std::string error;    ///< empty where the store is served
  };
  std::vector<Volume> volumes() const;

  /// Ends accepting, closes idle connections, and lets answers in flight end within
  /// limits.stop_time. Returns at once; callable from any thread and more than once.
  void stop();

  /// Returns when the server has stopped, by stop() or by a signal.
  void wait();

 private:
  struct State;
  explicit Server(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace isosplat
