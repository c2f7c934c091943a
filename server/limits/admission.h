#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace isosplat::server {

class Admission;

/// The entry of an open connection in Admission, until it is destroyed. The thread of the
/// connection reports its state, and Admission uses these states to choose which connection to
/// close for a new one.
class OpenConnection {
 public:
  using Clock = std::chrono::steady_clock;

  enum class Verdict : uint8_t {
    admitted,
    too_many,          ///< overall: refused with 503
    too_many_from_one  ///< from this address: refused with 429
  };
  enum class State : uint8_t {
    serving,  ///< the server works on its request
    waiting,  ///< for a request, for the rest of a request, or for a TLS handshake
    sending   ///< a response, as fast as the client receives it
  };

  ~OpenConnection();
  OpenConnection(const OpenConnection&) = delete;
  OpenConnection& operator=(const OpenConnection&) = delete;

  /// Differs from those of all other connections of the server.
  uint64_t id() const { return id_; }
  Verdict verdict() const { return verdict_; }

  /// For an admitted connection of Admission::kOfProxy: counts it for the client at this address
  /// from now on. The verdict becomes `too_many_from_one` if this client has too many connections.
  /// Call it on the connection's thread.
  void name(const std::string& address);

  /// Sets the function that closes the connection, provided that its state is still `chosen`, the
  /// state in which Admission chose it. The function must post to the connection's thread and
  /// return at once. Call this before set_state().
  void set_close(std::function<void(State chosen)> close) { close_ = std::move(close); }

  void set_state(State state, Clock::time_point since) {
    since_.store(since.time_since_epoch().count(), std::memory_order_relaxed);
    rate_.store(kUnknown, std::memory_order_relaxed);
    state_.store(state, std::memory_order_release);
  }
  State state() const { return state_.load(std::memory_order_acquire); }

  /// The client's recent receive rate in bytes per second, in the state `sending`.
  void set_rate(uint64_t rate) { rate_.store(rate, std::memory_order_relaxed); }

  /// Sets the client that owns the connection, if the request identified it by more than its
  /// address. Call it on the connection's thread.
  void set_client(const std::string& client);

  /// Reports that the connection was chosen to be closed, but has made progress in the meantime.
  /// Another one may be chosen.
  void keep();

 private:
  friend class Admission;
  static constexpr uint64_t kUnknown = std::numeric_limits<uint64_t>::max();

  OpenConnection(Admission& admission, uint64_t id, Verdict verdict, const std::string& address)
      : admission_(admission), id_(id), verdict_(verdict), address_(address), client_(address) {}

  Admission& admission_;
  const uint64_t id_;
  Verdict verdict_;
  std::string address_;  // guarded by Admission::mutex_
  std::function<void(State)> close_;
  std::atomic<State> state_{State::serving};
  std::atomic<Clock::rep> since_{0};
  std::atomic<uint64_t> rate_{kUnknown};
  std::string client_;       // written by the connection's thread, under Admission::mutex_
  size_t index_ = 0;         // in Admission::connections_; guarded by its mutex_
  bool is_closing_ = false;  // guarded by Admission::mutex_
};

/// Counts open connections, overall and by address, and refuses those above the limits. If the
/// server is full, it closes a connection for a new one: of the client with the most connections,
/// the one that has waited longest for a request, or that receives its response most slowly. So
/// clients that hold many connections, or are slow, cannot keep others out. Thread-safe.
class Admission {
 public:
  using Clock = OpenConnection::Clock;
  using Verdict = OpenConnection::Verdict;

  struct Limits {
    uint32_t connections = 1024;
    uint32_t per_address = 256;  ///< 0: no limit
    uint64_t least_rate = 0;     ///< bytes per second; a client that receives fewer is slow …
    /// … if it has been below this rate for this long.
    std::chrono::milliseconds patience{2000};
  };
  explicit Admission(Limits limits) : limits_(limits) {}

  /// The address to give for a connection of a trusted proxy, which carries requests of many
  /// clients: only the limit of all connections applies.
  static constexpr const char* kOfProxy = "";

  /// Returns the entry of a new connection, or null if too many refusals are being sent: close the
  /// connection at once then.
  std::unique_ptr<OpenConnection> enter(const std::string& address, Clock::time_point now);

  /// Closes a connection as if an unknown client had connected, because another resource of the
  /// process that connections need is used up. Returns whether a connection will end soon.
  bool make_room(Clock::time_point now);

  /// The number of connections may exceed the limit by this many while others are being closed.
  static constexpr uint32_t kMostAbove = 64;
  /// The maximum numbers of refusals being sent: of all, and to one address.
  static constexpr uint32_t kMostRefusals = 64;
  static constexpr uint32_t kMostRefusalsOfOne = 16;

 private:
  friend class OpenConnection;

  struct Counts {
    uint32_t open = 0;
    uint32_t refused = 0;
  };
  struct Client;
  using Clients = std::unordered_map<std::string_view, Client>;

  // The caller must hold mutex_.
  bool is_full(const std::string& address) const;
  void count(OpenConnection& connection);
  void uncount(OpenConnection& connection);
  bool close_for(std::string_view newcomer, Clock::time_point now);
  bool close(OpenConnection& connection);
  bool is_slow(const OpenConnection& connection, Clock::time_point now) const;

  const Limits limits_;
  std::mutex mutex_;
  // All of these are guarded by mutex_.
  uint64_t next_id_ = 0;
  std::vector<OpenConnection*> connections_;  ///< admitted
  uint32_t closing_ = 0;                      ///< of these
  uint32_t refusals_ = 0;
  std::unordered_map<std::string, Counts> by_address_;
};

}  // namespace isosplat::server
