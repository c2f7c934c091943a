#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <list>
#include <string>
#include <string_view>
#include <unordered_map>

namespace isosplat::server {

/// A queue of the requests of clients, by fair scheduling. The next item is the oldest one of the
/// client that has received the least service so far. Of clients with equal service, it is the one
/// whose last turn is longest ago. So a client with many requests delays only itself. Not
/// thread-safe.
template <class Item>
class FairQueue {
 public:
  size_t size() const { return size_; }

  size_t size_of(std::string_view client) const {
    const auto found = by_name_.find(client);
    return found == by_name_.end() ? 0 : found->second->items.size();
  }

  void push(const std::string& client, Item* item) {
    Client& its = find_or_add(client);
    its.items.push_back(item);
    ++size_;
  }

  /// Requires size() > 0. Call charge() once the item has been served.
  Item* pop() {
    const auto waits = [](const Client& client) { return !client.items.empty(); };
    auto next = std::ranges::find_if(clients_, waits);
    for (auto each = next; each != clients_.end(); ++each) {
      if (waits(*each) && each->served < next->served) next = each;
    }
    Item* const item = next->items.front();
    next->items.pop_front();
    --size_;
    ++next->in_service;
    least_ = std::max(least_, next->served);
    clients_.splice(clients_.end(), clients_, next);
    return item;
  }

  /// Adds the cost of a popped item to its client, in any unit.
  void charge(std::string_view client, uint64_t cost) {
    Client& its = *by_name_.find(client)->second;
    --its.in_service;
    its.served += cost;
    forget_idle();
  }

  /// Removes an item that has not been popped. Returns false if it is not in the queue.
  bool remove(std::string_view client, Item* item) {
    const auto found = by_name_.find(client);
    if (found == by_name_.end()) return false;
    auto& items = found->second->items;
    const auto at = std::ranges::find(items, item);
    if (at == items.end()) return false;
    items.erase(at);
    --size_;
    forget_idle();
    return true;
  }

  /// The items of the client that has the most, oldest first. Requires size() > 0.
  const std::deque<Item*>& most_of_one() const {
    return std::ranges::max_element(clients_, {},
                                    [](const Client& client) { return client.items.size(); })
        ->items;
  }

 private:
  struct Client {
    std::string name;
    uint64_t served = 0;
    size_t in_service = 0;
    std::deque<Item*> items{};
    bool is_idle() const { return items.empty() && in_service == 0; }
  };
  using Position = typename std::list<Client>::iterator;

  /// A new client starts with the service of the client that had the last turn, so it has no
  /// advantage over the others.
  Client& find_or_add(const std::string& name) {
    const auto found = by_name_.find(name);
    if (found != by_name_.end()) {
      found->second->served = std::max(found->second->served, least_);
      return *found->second;
    }
    clients_.push_back({name, least_});
    const Position added = std::prev(clients_.end());
    try {
      by_name_.emplace(added->name, added);
    } catch (...) {
      clients_.pop_back();
      throw;
    }
    return *added;
  }

  /// Forgets clients without items, if their service is no higher than that of a new client, or if
  /// there are too many of them.
  void forget_idle() {
    constexpr size_t kMostIdle = 1024;
    const bool are_many = clients_.size() > kMostIdle + size_;
    for (auto client = clients_.begin(); client != clients_.end();) {
      if (client->is_idle() && (are_many || client->served <= least_)) {
        by_name_.erase(client->name);
        client = clients_.erase(client);
      } else {
        ++client;
      }
    }
  }

  size_t size_ = 0;
  uint64_t least_ = 0;         ///< service of the client of the last turn; never decreases
  std::list<Client> clients_;  ///< in the order of their last turns
  std::unordered_map<std::string_view, Position> by_name_;
};

}  // namespace isosplat::server
