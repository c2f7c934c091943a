#include "server/limits/admission.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace isosplat::server {

using State = OpenConnection::State;

OpenConnection::~OpenConnection() {
  const std::lock_guard lock(admission_.mutex_);
  admission_.uncount(*this);
}

void OpenConnection::name(const std::string& address) {
  const std::lock_guard lock(admission_.mutex_);
  const bool is_too_many = admission_.is_full(address);
  admission_.uncount(*this);
  address_ = client_ = address;
  if (is_too_many) verdict_ = Verdict::too_many_from_one;
  admission_.count(*this);
}

void OpenConnection::set_client(const std::string& client) {
  if (client_ == client) return;
  const std::lock_guard lock(admission_.mutex_);
  client_ = client;
}

void OpenConnection::keep() {
  const std::lock_guard lock(admission_.mutex_);
  if (std::exchange(is_closing_, false)) --admission_.closing_;
}

/// The connections of one client that may be closed.
struct Admission::Client {
  uint32_t open = 0;
  std::vector<OpenConnection*> stuck;  ///< idle, or slow to receive a response
  OpenConnection* slowest = nullptr;   ///< of those that receive a response

  /// Waiting connections come first, ordered by how long they have waited; then those that receive,
  /// the slowest first.
  static auto order(const OpenConnection* connection) {
    const bool waits = connection->state() == State::waiting;
    const auto since = connection->since_.load(std::memory_order_relaxed);
    return std::tuple(!waits, waits ? 0 : connection->rate_.load(std::memory_order_relaxed), since);
  }
  auto first_stuck() const { return std::ranges::min_element(stuck, {}, order); }
  OpenConnection* take_first_stuck() {
    const auto first = first_stuck();
    OpenConnection* const connection = *first;
    stuck.erase(first);
    --open;
    return connection;
  }
};

std::unique_ptr<OpenConnection> Admission::enter(const std::string& address,
                                                 Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  Verdict verdict = Verdict::admitted;
  // Check this first, so that an address at its limit does not close the connections of others.
  if (is_full(address)) {
    verdict = Verdict::too_many_from_one;
  } else if (connections_.size() >= uint64_t{limits_.connections} + kMostAbove ||
             (connections_.size() - closing_ >= limits_.connections && !close_for(address, now))) {
    verdict = Verdict::too_many;
  }
  if (verdict != Verdict::admitted) {
    const auto found = by_address_.find(address);
    const bool has_enough = address != kOfProxy && found != by_address_.end() &&
                            found->second.refused >= kMostRefusalsOfOne;
    if (refusals_ >= kMostRefusals || has_enough) return nullptr;
  }
  std::unique_ptr<OpenConnection> slot(new OpenConnection(*this, next_id_++, verdict, address));
  count(*slot);
  return slot;
}

bool Admission::is_full(const std::string& address) const {
  if (limits_.per_address == 0 || address == kOfProxy) return false;
  const auto found = by_address_.find(address);
  return found != by_address_.end() && found->second.open >= limits_.per_address;
}

void Admission::count(OpenConnection& connection) {
  // Allocate before changing the counts: an allocation may fail.
  Counts& counts = by_address_[connection.address_];
  if (connection.verdict_ == Verdict::admitted) {
    connection.index_ = connections_.size();
    connections_.push_back(&connection);
    ++counts.open;
  } else {
    ++refusals_;
    ++counts.refused;
  }
}

void Admission::uncount(OpenConnection& connection) {
  const auto counts = by_address_.find(connection.address_);
  if (connection.verdict_ == Verdict::admitted) {
    connections_.back()->index_ = connection.index_;
    connections_[connection.index_] = connections_.back();
    connections_.pop_back();
    if (std::exchange(connection.is_closing_, false)) --closing_;
    --counts->second.open;
  } else {
    --refusals_;
    --counts->second.refused;
  }
  if (counts->second.open == 0 && counts->second.refused == 0) by_address_.erase(counts);
}

bool Admission::make_room(Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  return close_for({}, now);
}

bool Admission::is_slow(const OpenConnection& connection, Clock::time_point now) const {
  return connection.rate_.load(std::memory_order_relaxed) < limits_.least_rate &&
         connection.since_.load(std::memory_order_relaxed) <=
             (now - limits_.patience).time_since_epoch().count();
}

bool Admission::close(OpenConnection& connection) {
  connection.close_(connection.state());
  connection.is_closing_ = true;
  ++closing_;
  return true;
}

/// Closes connections for a new one of the client `newcomer`, in this order:
/// 1. idle or slow ones of larger clients, the largest first. Closes some more than are needed now,
///    so that a flood of connections does not repeat this search each time;
/// 2. the slowest one that receives a response, of a client that is more than twice as large;
/// 3. idle or slow ones of the newcomer, or of a client of the same size: an eighth of that
///    client's;
/// 4. one of any client that has waited for a request for a while: its client can open another.
/// Returns whether a connection will end soon.
bool Admission::close_for(std::string_view newcomer, Clock::time_point now) {
  Clients clients;
  OpenConnection* longest = nullptr;
  for (OpenConnection* const connection : connections_) {
    if (connection->is_closing_) continue;
    Client& client = clients[connection->client_];
    ++client.open;
    const State state = connection->state();
    if (state == State::serving) continue;
    if (state == State::waiting || is_slow(*connection, now)) client.stuck.push_back(connection);
    OpenConnection*& best = state == State::waiting ? longest : client.slowest;
    if (!best || Client::order(connection) < Client::order(best)) best = connection;
  }
  const uint32_t own = clients[newcomer].open + 1;
  const auto size_if = [](const auto& may_close) {
    return [&may_close](const auto& item) { return may_close(item.second) ? item.second.open : 0; };
  };
  const auto has_stuck = [](const Client& client) { return !client.stuck.empty(); };
  const auto has_slowest = [](const Client& client) { return client.slowest != nullptr; };

  const uint32_t most = std::max(limits_.connections / 32, 1u);
  bool has_closed = false;
  for (uint32_t closed = 0; closed < most; ++closed) {
    Client& largest = std::ranges::max_element(clients, {}, size_if(has_stuck))->second;
    if (!has_stuck(largest) || largest.open <= own) break;
    has_closed = close(*largest.take_first_stuck());
  }
  if (has_closed) return true;

  const Client& largest = std::ranges::max_element(clients, {}, size_if(has_slowest))->second;
  if (has_slowest(largest) && largest.open > 2 * own) return close(*largest.slowest);

  Client* chosen = nullptr;
  const OpenConnection* first_of_chosen = nullptr;
  for (auto& [name, client] : clients) {
    if (!has_stuck(client) || (name != newcomer && client.open < own)) continue;
    const OpenConnection* const first = *client.first_stuck();
    if (chosen && !(Client::order(first) < Client::order(first_of_chosen))) continue;
    chosen = &client;
    first_of_chosen = first;
  }
  if (chosen) {
    const uint32_t share = std::max(chosen->open / 8, 1u);
    for (uint32_t closed = 0; closed < share && has_stuck(*chosen); ++closed) {
      close(*chosen->take_first_stuck());
    }
    return true;
  }

  const auto long_ago = (now - limits_.patience).time_since_epoch().count();
  const bool is_long = longest && longest->since_.load(std::memory_order_relaxed) <= long_ago;
  return is_long && close(*longest);
}

}  // namespace isosplat::server
