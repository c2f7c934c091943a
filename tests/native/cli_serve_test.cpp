// isosplat serve as a service: its configuration file, the sockets that systemd passes, and its
// notifications to systemd.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/native/cli_program.h"

namespace isosplat::test {
namespace {

std::string store_in(const TempFolder& folder) {
  EXPECT_EQ(run({"build", write_ball(folder, 12)}).exit_code, 0);
  return folder / "ball.isosplat";
}

/// A listening socket on a free port of the loopback interface.
struct Listener {
  Listener() {
    socket = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    EXPECT_EQ(::bind(socket, reinterpret_cast<sockaddr*>(&address), length), 0);
    EXPECT_EQ(::listen(socket, 16), 0);
    EXPECT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length), 0);
    port = ntohs(address.sin_port);
  }
  ~Listener() { ::close(socket); }
  int socket = -1;
  uint16_t port = 0;
};

/// The response to a request for a path, including its header.
std::string get(uint16_t port, const std::string& path) {
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  std::string text;
  if (::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) {
    const std::string request =
        "GET " + path + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    EXPECT_EQ(::send(socket, request.data(), request.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(request.size()));
    char buffer[4096];
    for (ssize_t count; (count = ::recv(socket, buffer, sizeof buffer, 0)) > 0;) {
      text.append(buffer, static_cast<size_t>(count));
    }
  }
  ::close(socket);
  return text;
}

/// The datagrams that a program sends to NOTIFY_SOCKET.
class Notifications {
  const TempFolder folder_;

 public:
  const std::string path = folder_ / "notify";

  Notifications() {
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    const timeval time{120, 0};  // as long as a slow machine may need
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &time, sizeof time);
  }
  ~Notifications() { ::close(socket_); }

  /// Waits for the next notification.
  std::string next() {
    char buffer[256];
    const ssize_t count = ::recv(socket_, buffer, sizeof buffer, 0);
    return count < 0 ? "(none)" : std::string(buffer, static_cast<size_t>(count));
  }

 private:
  int socket_ = -1;
};

/// Starts the program with `socket` as systemd passes it.
pid_t start_with_socket(const Call& call, int socket, const std::string& out,
                        const std::string& err, const std::string& notify) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  ::dup2(socket, 3);
  ::setenv("LISTEN_FDS", "1", 1);
  ::setenv("LISTEN_PID", std::to_string(::getpid()).c_str(), 1);
  ::setenv("NOTIFY_SOCKET", notify.c_str(), 1);
  const auto redirect = [](const std::string& path, int to) {
    ::dup2(::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), to);
  };
  redirect(out, 1);
  redirect(err, 2);
  std::vector<char*> arguments;
  std::string program = ISOSPLAT_PROGRAM;
  arguments.push_back(program.data());
  std::vector<std::string> copies = call.arguments;
  for (std::string& argument : copies) arguments.push_back(argument.data());
  arguments.push_back(nullptr);
  ::execv(program.c_str(), arguments.data());
  ::_exit(127);
}

TEST(CliServe, UsesTheSocketOfSystemdAndReportsItsState) {
  const TempFolder folder;
  const std::string store = store_in(folder);
  const Listener listener;
  Notifications notifications;
  const std::string out = folder / "out", err = folder / "err";
  // The port in the options is in use, so the server must use the passed socket.
  const pid_t child =
      start_with_socket({.arguments = {"serve", store, "--port", std::to_string(listener.port)}},
                        listener.socket, out, err, notifications.path);
  EXPECT_EQ(notifications.next(), "READY=1") << read_file(err);
  EXPECT_TRUE(get(listener.port, "/readyz").starts_with("HTTP/1.1 200 "));
  // systemd sends SIGHUP to reload the service, even if no files need to be read again.
  ::kill(child, SIGHUP);
  EXPECT_TRUE(notifications.next().starts_with("RELOADING=1\nMONOTONIC_USEC="));
  EXPECT_EQ(notifications.next(), "READY=1\nSTATUS=Reloaded.");
  EXPECT_TRUE(get(listener.port, "/readyz").starts_with("HTTP/1.1 200 "));
  ::kill(child, SIGTERM);
  EXPECT_EQ(notifications.next(), "STOPPING=1");
  EXPECT_EQ(wait_for(child, out, err).exit_code, 0);
}

TEST(CliServe, ReportsAFailedReloadToSystemd) {
  const TempFolder folder;
  const std::string store = store_in(folder), tokens = folder / "tokens";
  write_file(tokens, "token-0123456789abcdef *\n");
  const Listener listener;
  Notifications notifications;
  const std::string out = folder / "out", err = folder / "err";
  const Call call{.arguments = {"serve", store, "--token-file", tokens}};
  const pid_t child = start_with_socket(call, listener.socket, out, err, notifications.path);
  EXPECT_EQ(notifications.next(), "READY=1") << read_file(err);
  // The check that the unit runs before it reloads (ExecReload=).
  std::vector<std::string> check = call.arguments;
  check.push_back("--check");
  EXPECT_EQ(run(check).exit_code, 0);
  write_file(tokens, "short *\n");
  const Ended checked = run(check);
  EXPECT_EQ(checked.exit_code, 2);
  EXPECT_NE(checked.err.find(tokens + ": line 1: expected"), std::string::npos) << checked.err;
  ::kill(child, SIGHUP);
  EXPECT_TRUE(notifications.next().starts_with("RELOADING=1\n"));
  const std::string status = notifications.next();
  EXPECT_TRUE(status.starts_with("READY=1\nSTATUS=Reload failed: " + tokens + ": line 1"))
      << status;
  EXPECT_TRUE(get(listener.port, "/v1/volumes").starts_with("HTTP/1.1 401 "))
      << "the old ones stay";
  ::kill(child, SIGTERM);
  EXPECT_EQ(wait_for(child, out, err).exit_code, 0);
}

/// Waits until a program has written a text to a file, and returns the number that follows it.
int number_behind(const std::string& file, const std::string& text) {
  for (int i = 0; i < 12'000; ++i) {
    const std::string written = read_file(file);
    const size_t at = written.rfind(text);
    if (at != std::string::npos &&
        written.find_first_not_of("0123456789", at + text.size()) != std::string::npos) {
      return std::stoi(written.substr(at + text.size()));
    }
    usleep(10'000);
  }
  ADD_FAILURE() << file << ": expected '" << text << "': " << read_file(file);
  return 0;
}

/// A connection that has begun to read a store file, slowly.
struct SlowReader {
  explicit SlowReader(uint16_t port, const std::string& path) {
    socket = ::socket(AF_INET, SOCK_STREAM, 0);
    const int small = 4096;
    ::setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &small, sizeof small);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    EXPECT_EQ(::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    const std::string request = "GET " + path + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
    EXPECT_GT(::send(socket, request.data(), request.size(), MSG_NOSIGNAL), 0);
    char first[16];
    text.append(first, static_cast<size_t>(::recv(socket, first, sizeof first, MSG_WAITALL)));
  }
  ~SlowReader() { ::close(socket); }
  /// Reads up to the end of the connection.
  std::string rest() {
    std::vector<char> buffer(1 << 16);
    for (ssize_t count; (count = ::recv(socket, buffer.data(), buffer.size(), 0)) > 0;) {
      text.append(buffer.data(), static_cast<size_t>(count));
    }
    return text;
  }
  int socket = -1;
  std::string text;
};

TEST(CliServe, ANewProcessTakesOverWhileTransfersGoOn) {
  const TempFolder folder;
  // Random bytes at the end of the volume make the store larger than the buffers of sockets.
  const int side = 160;
  std::string voxels(static_cast<size_t>(side) * side * side, '\0');
  uint32_t state = 1;
  for (char& voxel : voxels)
    voxel = static_cast<char>((state = state * 1664525 + 1013904223) >> 24);
  write_file(folder / "noise.nrrd",
             fmt::format("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {0} {0} {0}\n"
                         "spacings: 1 1 1\nencoding: raw\n\n",
                         side) +
                 voxels);
  ASSERT_EQ(run({"build", folder / "noise.nrrd", "--no-thumbnail"}).exit_code, 0);
  const std::string store = folder / "noise.isosplat", file = read_file(store);
  ASSERT_GT(file.size(), 3'000'000u);
  const std::string out = folder / "out", err = folder / "err", config = folder / "server.toml";
  write_file(config, "stores = [\"" + store + "\"]\nport = 0\n");
  const pid_t old = start({.arguments = {"serve", "--config", config}}, out, err);
  const auto port = static_cast<uint16_t>(number_behind(out, "http://localhost:"));
  const std::string list = get(port, "/v1/volumes/noise");
  const size_t at = list.find("\"contentId\":\"") + 13;
  const std::string path = "/v1/volumes/noise/" + list.substr(at, 32) + "/file";
  SlowReader reader(port, path);

  // If the new configuration is invalid, the old process continues.
  write_file(config, "prot = 1\n");
  ::kill(old, SIGUSR2);
  while (read_file(err).find("this process goes on") == std::string::npos) usleep(10'000);
  EXPECT_TRUE(get(port, "/readyz").starts_with("HTTP/1.1 200 "));

  // The new process gets the sockets of the old one, so it does not use this port.
  write_file(config, "stores = [\"" + store + "\"]\nport = 1\n");
  ::kill(old, SIGUSR2);
  const pid_t successor = number_behind(err, "handed over to process ");
  ASSERT_GT(successor, 1);
  EXPECT_NE(successor, old);
  for (int i = 0; i < 20; ++i) {
    EXPECT_TRUE(get(port, "/readyz").starts_with("HTTP/1.1 200 ")) << i;
  }
  const std::string response = reader.rest();
  EXPECT_TRUE(response.ends_with(file)) << response.size();
  EXPECT_EQ(wait_for(old, out, err).exit_code, 0);
  EXPECT_TRUE(get(port, "/readyz").starts_with("HTTP/1.1 200 "));
  ::kill(successor, SIGTERM);
  while (!get(port, "/readyz").empty()) usleep(10'000);
}

TEST(CliServe, TheHealthCommandChecksTheServer) {
  const TempFolder folder;
  const std::string out = folder / "out", err = folder / "err";
  write_file(folder / "broken.isosplat", "not a store");
  const pid_t child = start({.arguments = {"serve", folder.path(), "--port", "0"}}, out, err);
  const std::string port = std::to_string(number_behind(out, "http://localhost:"));
  const Ended unwell = run({"health", "--port", port});
  EXPECT_EQ(unwell.exit_code, 1);
  EXPECT_NE(unwell.err.find("found 503"), std::string::npos) << unwell.err;
  store_in(folder);
  while (run({"health", "--port", port}).exit_code != 0) usleep(10'000);
  ::kill(child, SIGTERM);
  EXPECT_EQ(wait_for(child, out, err).exit_code, 0);
  EXPECT_EQ(run({"health", "--port", port}).exit_code, 1);
  EXPECT_EQ(run({"health", "--port", "0"}).exit_code, 2);
}

TEST(CliServe, RefusesASocketThatIsNotTcp) {
  const TempFolder folder;
  const std::string store = store_in(folder);
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  const std::string out = folder / "out", err = folder / "err";
  const Ended ended =
      wait_for(start_with_socket({.arguments = {"serve", store}}, socket, out, err, ""), out, err);
  ::close(socket);
  EXPECT_EQ(ended.exit_code, 1);
  EXPECT_NE(ended.err.find("expected a listening socket of TCP"), std::string::npos) << ended.err;
}

TEST(CliServe, TakesOptionsFromAFileAndTheCommandLineFirst) {
  const TempFolder folder;
  const std::string store = store_in(folder), log = folder / "access.log";
  const std::string config = folder / "server.toml";
  write_file(config, "# comment\nstores = [\"" + store + "\"]\nport = 1\nlog-format = \"json\"\n" +
                         "access-log = \"" + log + "\"\npublic = false\nhost = \"127.0.0.1\"\n");
  const Ended served = serve_until_logged(
      {.arguments = {"serve", "--config", config, "--port", "0"}}, "volume ball: ");
  EXPECT_EQ(served.exit_code, 0) << served.err;
  EXPECT_NE(served.err.find("volume ball: "), std::string::npos) << served.err;
  EXPECT_EQ(access(log.c_str(), F_OK), 0) << "the access log of the file was not opened";
}

/// A server whose standard output and error are the descriptors of the test, on a free port.
class Piped {
 public:
  /// `output`: a descriptor, which the constructor closes in the test's process.
  Piped(const std::string& store, int output) {
    child_ = ::fork();
    if (child_ == 0) {
      ::dup2(listener_.socket, 3);
      ::setenv("LISTEN_FDS", "1", 1);
      ::setenv("LISTEN_PID", std::to_string(::getpid()).c_str(), 1);
      ::dup2(output, 1);
      ::dup2(output, 2);
      std::string program = ISOSPLAT_PROGRAM, command = "serve", path = store, verbose = "-v";
      char* arguments[] = {program.data(), command.data(), path.data(), verbose.data(), nullptr};
      ::execv(program.c_str(), arguments);
      ::_exit(127);
    }
    ::close(output);
  }

  /// Makes requests whose lines in the log are 4 KB each, and checks their responses.
  void request(int count) const {
    for (int i = 0; i < count; ++i) {
      EXPECT_TRUE(get(listener_.port, "/?" + std::string(4000, 'x')).starts_with("HTTP/1.1 200 "));
    }
  }

  uint64_t dropped() const {
    const std::string text = get(listener_.port, "/metrics");
    const std::string name = "\nisosplat_log_lines_dropped_total{log=\"server\"} ";
    const size_t at = text.find(name);
    return at == text.npos ? 0 : std::stoull(text.substr(at + name.size()));
  }

  void await_dropped() const {
    for (int i = 0; i < 3000 && dropped() == 0; ++i) usleep(10'000);
    EXPECT_GT(dropped(), 0u);
  }

  /// One SIGTERM ends it.
  void stop() const {
    ::kill(child_, SIGTERM);
    int status = 0;
    ::waitpid(child_, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  }

 private:
  const Listener listener_;
  pid_t child_ = -1;
};

TEST(CliServe, ContinuesWhenStandardErrorIsFull) {
  const TempFolder folder;
  const Piped server(store_in(folder), ::open("/dev/full", O_WRONLY | O_CLOEXEC));
  server.request(3);
  server.await_dropped();
  server.stop();
}

TEST(CliServe, ContinuesWhenAPipeHasNoReader) {
  const TempFolder folder;
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  const Piped server(store_in(folder), ends[1]);
  server.request(1);
  ::close(ends[0]);
  server.request(3);
  server.await_dropped();
  server.stop();
}

TEST(CliServe, ContinuesWhenAPipeBlocks) {
  const TempFolder folder;
  const std::string store = store_in(folder);
  for (const int flags : {0, O_NONBLOCK}) {  // O_NONBLOCK: EAGAIN
    int ends[2];
    ASSERT_EQ(::pipe2(ends, O_CLOEXEC | flags), 0);
    const Piped server(store, ends[1]);
    // More than the log keeps at most: 1 MiB that is being written and 1 MiB that waits.
    server.request(600);
    server.await_dropped();
    server.stop();
    ::close(ends[0]);
  }
}

TEST(CliServe, NamesTheErrorInTheConfigurationFile) {
  const TempFolder folder;
  const std::string config = folder / "server.toml";
  struct Case {
    const char* text;
    const char* message;
  };
  for (const Case& c :
       {Case{"prot = 8080\n", "'prot'"}, Case{"port = 99999\n", "99999"},
        Case{"public = maybe\n", "public: expected true or false"},
        Case{"[section]\nport = 1\n", "'section'"}, Case{"config = \"other\"\n", "'config'"},
        Case{"\x01\x02\x03\n", "server.toml"}, Case{"log-format = \"xml\"\n", "xml"}}) {
    write_file(config, c.text);
    const Ended ended = run({"serve", folder.path(), "--config", config});
    EXPECT_EQ(ended.exit_code, 2) << c.text << ended.err;
    EXPECT_NE(ended.err.find(c.message), std::string::npos) << c.text << ended.err;
  }
  EXPECT_EQ(run({"serve", folder.path(), "--config", folder / "nothing"}).exit_code, 2);
}

TEST(CliServe, RefusesInvalidValuesOfOptions) {
  const TempFolder folder;
  for (const std::vector<std::string>& options : {std::vector<std::string>{"--rate-requests", "-1"},
                                                  {"--rate-bytes", "many"},
                                                  {"--bytes-in-flight", "x"},
                                                  {"--log-format", "xml"},
                                                  {"--trusted-proxy", "10.0.0.1/8"},
                                                  {"--proxy-header", "x-real-ip"},
                                                  {"--user-header", "X-User"},
                                                  {"--cookie-name", "a=b"},
                                                  {"--hsts", "1h"},
                                                  {"--http-port", "0"},
                                                  {"--jwt-keys", "keys.json"},
                                                  {"--disk-threads", "0"}}) {
    std::vector<std::string> arguments = {"serve", folder.path(), "--port", "0"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    EXPECT_EQ(run(arguments).exit_code, 2) << options[0];
  }
}

}  // namespace
}  // namespace isosplat::test
