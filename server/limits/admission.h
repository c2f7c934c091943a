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

/// A connection's place among those that are open, until it is destroyed. The thread of the
/// connection says how it gets on; Admission chooses by that which one to close for another.
class OpenConnection {
 public:
  using Clock = std::chrono::steady_clock;

  enum class Verdict : uint8_t {
    admitted,
    too_many,          ///< overall: refused with 503
    too_many_from_one  ///< from this address: refused with 429
  };
  enum class State : uint8_t {
    serving,  ///< the server is at work for it
    waiting,  ///< for a request, the rest of one, or a TLS handshake
    sending   ///< a response, as fast as the client takes it
  };

  ~OpenConnection();
  OpenConnection(const OpenConnection&) = delete;
  OpenConnection& operator=(const OpenConnection&) = delete;

  /// Differs from those of all other connections of the server.
  uint64_t id() const { return id_; }
  Verdict verdict() const { return verdict_; }

  /// For an admitted connection of Admission::kOfProxy: it is one of the client at this address
  /// from now on. The verdict is then `too_many_from_one` if it has too many. Call it on the
  /// connection's thread.
  void name(const std::string& address);

  /// How it is closed if its state is still the one in which it was chosen: posts to its thread,
  /// and returns at once. Set it before set_state().
  void set_close(std::function<void(State chosen)> close) { close_ = std::move(close); }

  void set_state(State state, Clock::time_point since) {
    since_.store(since.time_since_epoch().count(), std::memory_order_relaxed);
    rate_.store(kUnknown, std::memory_order_relaxed);
    state_.store(state, std::memory_order_release);
  }
  State state() const { return state_.load(std::memory_order_acquire); }

  /// Bytes per second that the client has taken lately, in the state `sending`.
  void set_rate(uint64_t rate) { rate_.store(rate, std::memory_order_relaxed); }

  /// Whom the connection belongs to, if that is known better than by its address. Call it on the
  /// connection's thread.
  void set_client(const std::string& client);

  /// It was to be closed, but has gone on in the meantime: another one may be chosen.
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
/// server is full, it closes connections that make little progress for new ones: those of the
/// client that has the most, and of these the one that waits for a request longest, or takes its
/// response slowest. So nobody is kept out by clients that hold many connections, or are slow.
/// Thread-safe.
class Admission {
 public:
  using Clock = OpenConnection::Clock;
  using Verdict = OpenConnection::Verdict;

  struct Limits {
    uint32_t connections = 1024;
    uint32_t per_address = 256;  ///< 0: no limit
    uint64_t least_rate = 0;     ///< a client that takes fewer bytes per second is slow …
    /// … if it has done so for this long.
    std::chrono::milliseconds patience{2000};
  };
  explicit Admission(Limits limits) : limits_(limits) {}

  /// The address of a trusted proxy, whose connections are those of many clients: only the limit of
  /// all connections applies.
  static constexpr const char* kOfProxy = "";

  /// The place of a new connection. Null if too many refusals are being sent: close it at once.
  std::unique_ptr<OpenConnection> enter(const std::string& address, Clock::time_point now);

  /// Closes a connection, as if one of an unknown client had come: the process has used up
  /// something else that connections need. Returns whether one will end soon.
  bool make_room(Clock::time_point now);

  /// Connections may be above the limit, until those that are closed have ended.
  static constexpr uint32_t kMostAbove = 64;
  /// Refusals that are sent at a time, and those to one address.
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
