#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/server.h"
#include "tests/server/http_client.h"
#include "tests/server/test_store.h"

namespace isosplat::server::test {

/// A folder with one store, "alpha", and a server for it once start() was called.
class ServerTest : public ::testing::Test {
 protected:
  ServerTest() {
    write_file(folder.path() / "alpha.isosplat", alpha.file);
    options.port = 0;
    options.threads = 2;
    options.stores = {folder.path()};
    options.scan_interval = std::chrono::milliseconds(20);
    options.log = [this](std::string_view line) {
      const std::lock_guard lock(log_mutex);
      log_lines.emplace_back(line);
    };
  }

  ~ServerTest() override { server.reset(); }

  void start() {
    Result<std::unique_ptr<Server>> started = Server::start(options);
    ASSERT_TRUE(started) << started.error().message;
    server = std::move(*started);
  }

  uint16_t port() const { return server->port(); }

  /// A path below alpha's content.
  std::string content(const std::string& rest) const {
    return "/v1/volumes/alpha/" + alpha.content + "/" + rest;
  }

  bool log_mentions(std::string_view text) {
    const std::lock_guard lock(log_mutex);
    for (const std::string& line : log_lines) {
      if (line.find(text) != std::string::npos) return true;
    }
    return false;
  }

  /// Waits until the condition holds, for as long as a slow machine may need.
  template <class Condition>
  static bool eventually(Condition condition) {
    for (int i = 0; i < 12'000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  /// Whether the server logs the text within that time: it may log what it did after its response.
  bool will_log(std::string_view text) {
    return eventually([&] { return log_mentions(text); });
  }

  /// The number of open descriptors of this program: those of the server and of the test's clients.
  static size_t open_descriptors() {
    size_t count = 0;
    for ([[maybe_unused]] const auto& each : std::filesystem::directory_iterator("/proc/self/fd")) {
      ++count;
    }
    return count;
  }

  const KnownStore alpha = make_store(1);
  TemporaryFolder folder;
  ServerOptions options;
  std::unique_ptr<Server> server;

 private:
  std::mutex log_mutex;
  std::vector<std::string> log_lines;
};

inline std::string text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline std::string place_of(const KnownChunk& chunk) {
  return chunk_name(chunk.block, chunk.band);
}

}  // namespace isosplat::server::test
