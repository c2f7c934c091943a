#include "server/access_loader.h"

#include <fmt/format.h>

#include <chrono>
#include <new>
#include <utility>

#include "server/access/jwt.h"
#include "server/access_options.h"
#include "server/net/http_get.h"

namespace isosplat::server {

Result<void> AccessLoader::prepare() {
  Result<void> loaded = load();
  if (loaded && is_address(options_.jwt_keys)) are_keys_wanted_ = !fetch_keys();
  return loaded;
}

Result<void> AccessLoader::load() {
  const std::lock_guard lock(load_mutex_);
  auto rules = read_access(options_, fetched_keys_);
  if (!rules) return tl::unexpected(rules.error());
  for (const std::string& warning : secret_file_warnings(options_)) log_.line(warning);
  has_rules_ = !(*rules)->is_open();
  router_.set_access(std::move(*rules));
  return {};
}

/// Fetches the keys of the identity provider, and uses them. If that fails, returns false and keeps
/// the previous keys.
bool AccessLoader::fetch_keys() {
  const auto answer = http_get(options_.jwt_keys, {.timeout = std::chrono::seconds(5)});
  std::string problem;
  if (!answer) {
    problem = answer.error().message;
  } else if (answer->status != 200) {
    problem = fmt::format("{}: status {}", options_.jwt_keys, answer->status);
  } else {
    const std::lock_guard lock(load_mutex_);
    if (answer->body == fetched_keys_) return true;
    const auto verifier = JwtVerifier::create(answer->body, options_.jwt);
    if (verifier) {
      fetched_keys_ = answer->body;
    } else {
      problem = fmt::format("{}: {}", options_.jwt_keys, verifier.error().message);
    }
  }
  if (problem.empty()) {
    const Result<void> loaded = load();
    if (loaded) {
      log_.line(fmt::format("{}: keys of the identity provider: read", options_.jwt_keys));
      return true;
    }
    problem = loaded.error().message;
  }
  log_.line(fmt::format("keys of the identity provider: those from before stay: {}", problem));
  return false;
}

/// Fetches the keys regularly until the server stops. An identity provider publishes a new key some
/// time before it signs with it.
void AccessLoader::follow_keys() {
  bool is_fetched = true;  // prepare() has tried
  while (!stopping_) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, is_fetched ? std::chrono::minutes(5) : std::chrono::seconds(30),
                      [this] { return stopping_ || are_keys_wanted_; });
    are_keys_wanted_ = false;
    lock.unlock();
    try {
      if (!stopping_) is_fetched = fetch_keys();
    } catch (const std::bad_alloc&) {
      ++metrics_.out_of_memory;
      is_fetched = false;
    }
  }
}

void AccessLoader::start() {
  if (is_address(options_.jwt_keys)) thread_ = std::thread([this] { follow_keys(); });
}

void AccessLoader::want_keys() {
  {
    const std::lock_guard lock(mutex_);
    are_keys_wanted_ = true;
  }
  changed_.notify_all();
}

void AccessLoader::wake() {
  {
    const std::lock_guard lock(mutex_);
  }  // prevents a change between the test of `stopping` and the wait
  changed_.notify_all();
}

void AccessLoader::join() {
  if (thread_.joinable()) thread_.join();
}

}  // namespace isosplat::server
