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

/// What clients wait for. The next is of the client that was served least lately, and of its items
/// the oldest; of clients that were served alike, the one whose last turn is longest ago. So a
/// client that asks for much delays itself. Not thread-safe.
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

  /// Requires size() > 0. Call charge() when the item was served.
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

  /// The client's item that was popped has cost so much, in any unit.
  void charge(std::string_view client, uint64_t cost) {
    Client& its = *by_name_.find(client)->second;
    --its.in_service;
    its.served += cost;
    forget_idle();
  }

  /// Takes an item out that was not popped. False if it is not there.
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

  /// The items of the client that has most, the oldest first. Requires size() > 0.
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

  /// A new client is one that was served as little as any that had its turn.
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

  /// Clients without items are remembered for what they were served, as long as that says
  /// something, and as long as they are not too many.
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
  uint64_t least_ = 0;         ///< what the client of the last turn had been served; never falls
  std::list<Client> clients_;  ///< in the order of their last turns
  std::unordered_map<std::string_view, Position> by_name_;
};

}  // namespace isosplat::server
