#include "server/server.h"

#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <condition_variable>
#include <csignal>
#include <mutex>
#include <system_error>
#include <thread>
#include <unordered_set>
#include <utility>

#include "server/admission.h"
#include "server/catalog.h"
#include "server/connection.h"
#include "server/router.h"

namespace isosplat {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using tcp = asio::ip::tcp;

template <class T>
using Awaitable = asio::awaitable<T, Executor>;

constexpr auto kAwait = asio::as_tuple(asio::use_awaitable_t<Executor>{});

using WorkGuard = asio::executor_work_guard<Executor>;
using Acceptor = asio::basic_socket_acceptor<tcp, Executor>;

/// What connections are counted by: an IPv4 address, or the first 64 bits of an IPv6 address, which
/// is what one client gets.
std::string address_key(const asio::ip::address& address) {
  if (address.is_v4()) return address.to_string();
  const asio::ip::address_v6 v6 = address.to_v6();
  if (v6.is_v4_mapped()) return asio::ip::make_address_v4(asio::ip::v4_mapped, v6).to_string();
  auto bytes = v6.to_bytes();
  if (!v6.is_loopback()) std::fill(bytes.begin() + 8, bytes.end(), static_cast<unsigned char>(0));
  return asio::ip::address_v6(bytes).to_string();
}

/// A thread, and the connections that live on it.
class Worker {
 public:
  explicit Worker(const ConnectionShared& shared, Admission& admission)
      : shared_(shared), admission_(admission), guard_(context_.get_executor()) {}

  asio::io_context& context() { return context_; }

  /// On any thread.
  void adopt(Socket socket, std::string address, Admission::Verdict verdict) {
    asio::post(context_,
               [this, socket = std::move(socket), address = std::move(address), verdict]() mutable {
                 asio::co_spawn(context_, serve(std::move(socket), std::move(address), verdict),
                                asio::detached);
               });
  }

  /// On any thread, after `shared.stopping` was set.
  void stop() {
    asio::post(context_, [this] {
      for (Connection* connection : connections_) connection->stop();
      deadline_.expires_after(shared_.limits.stop_time);
      deadline_.async_wait([this](const error_code& error) {
        if (!error) abort_all();
      });
      finish_if_done();
    });
  }

  /// On any thread, after stop().
  void abort() {
    asio::post(context_, [this] { abort_all(); });
  }

  void run() { context_.run(); }

 private:
  Awaitable<void> serve(Socket socket, std::string address, Admission::Verdict verdict) {
    std::unique_ptr<Response> refusal;
    if (verdict == Admission::Verdict::too_many) {
      refusal = std::make_unique<Response>(
          error_response(503, "too_many_connections",
                         "the server has as many connections as it takes: ask again "
                         "in a second"));
    } else if (verdict == Admission::Verdict::too_many_from_one) {
      refusal = std::make_unique<Response>(
          error_response(429, "too_many_connections",
                         "this address has as many connections as it may: close "
                         "some, or ask again in a second"));
    }
    if (refusal) {
      refusal->set("Retry-After", "1");
      refusal->set("Access-Control-Allow-Origin", "*");
      refusal->set("X-Content-Type-Options", "nosniff");
    }
    const Membership membership(*this, std::move(socket), std::move(address), verdict);
    co_await membership.connection->run(std::move(refusal));
  }

  /// A connection's place in the books, given back however its coroutine ends.
  struct Membership {
    Membership(Worker& its_worker, Socket socket, std::string its_address,
               Admission::Verdict its_verdict)
        : worker(its_worker),
          address(std::move(its_address)),
          verdict(its_verdict),
          connection(std::make_unique<Connection>(std::move(socket), address, its_worker.shared_)) {
      worker.connections_.insert(connection.get());
    }
    Membership(const Membership&) = delete;
    Membership& operator=(const Membership&) = delete;
    ~Membership() {
      worker.connections_.erase(connection.get());
      worker.admission_.leave(address, verdict);
      if (worker.shared_.stopping) worker.finish_if_done();
    }
    Worker& worker;
    std::string address;
    Admission::Verdict verdict;
    std::unique_ptr<Connection> connection;
  };

  void abort_all() {
    for (Connection* connection : connections_) connection->abort();
  }

  void finish_if_done() {
    if (!connections_.empty()) return;
    deadline_.cancel();
    guard_.reset();
  }

  const ConnectionShared& shared_;
  Admission& admission_;
  std::unordered_set<Connection*> connections_;
  asio::io_context context_{1};
  WorkGuard guard_;
  asio::basic_waitable_timer<std::chrono::steady_clock,
                             asio::wait_traits<std::chrono::steady_clock>, Executor>
      deadline_{context_.get_executor()};
};

Error io_failure(std::string message) {
  return {Status::io_error, std::move(message)};
}

/// Each store and each connection holds a file open: as many as the process may.
void raise_open_file_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

struct Server::State {
  explicit State(ServerOptions given)
      : options(std::move(given)),
        catalog(options.stores, options.limits.directory_bytes,
                [this](std::string_view line) { log(line); }),
        router(catalog, {options.limits.query_bytes, options.limits.query_chunks,
                         options.limits.query_directory_bytes, options.limits.target_bytes}),
        admission(options.limits.connections, options.limits.connections_per_address),
        shared{router, options.limits, stopping, {}, {}} {
    if (options.log) shared.log = [this](std::string_view line) { log_fault(line); };
    if (options.access_log) {
      shared.access_log = [this](std::string_view line) {
        const std::lock_guard lock(log_mutex);
        options.access_log(line);
      };
    }
  }

  ~State() {
    stop();
    if (control_thread.joinable()) control_thread.join();
    if (scan_thread.joinable()) scan_thread.join();
    for (std::thread& thread : worker_threads) thread.join();
  }

  void log(std::string_view line) {
    if (!options.log) return;
    const std::lock_guard lock(log_mutex);
    options.log(line);
  }

  /// Faults come as often as clients ask for what is broken: a few lines a second say it.
  void log_fault(std::string_view line) {
    constexpr uint32_t kLinesPerSecond = 10;
    const auto second = std::chrono::floor<std::chrono::seconds>(std::chrono::steady_clock::now());
    const std::lock_guard lock(log_mutex);
    if (second != fault_second) {
      fault_second = second;
      faults_this_second = 0;
    }
    if (++faults_this_second <= kLinesPerSecond) options.log(line);
  }

  Result<void> load_page();
  Result<void> bind();
  void run();
  Awaitable<void> accept_on(Acceptor& acceptor);
  void wait_for_signal();
  void scan_regularly();
  void stop();
  void drop_connections();

  const ServerOptions options;
  std::mutex log_mutex;
  std::chrono::time_point<std::chrono::steady_clock, std::chrono::seconds>
      fault_second;                 // guarded by log_mutex
  uint32_t faults_this_second = 0;  // guarded by log_mutex
  std::atomic<bool> stopping{false};
  Catalog catalog;
  Router router;
  Admission admission;
  ConnectionShared shared;
  uint64_t page_signature = 0;
  uint16_t bound_port = 0;

  std::vector<std::unique_ptr<Worker>> workers;
  std::vector<std::thread> worker_threads;
  std::atomic<size_t> next_worker{0};

  // Accepting and signals have a thread of their own: it goes on while workers read from disks.
  asio::io_context control{1};
  std::vector<Acceptor> acceptors;
  std::optional<asio::signal_set> signals;
  std::thread control_thread;
  std::thread scan_thread;

  std::mutex done_mutex;
  std::condition_variable done_changed;
  size_t workers_running = 0;  // guarded by done_mutex
};

Result<void> Server::State::load_page() {
  if (options.web_root.empty()) return {};
  page_signature = PageAssets::signature(options.web_root);
  auto page = PageAssets::load(options.web_root, options.limits.page_asset_bytes,
                               [this](std::string_view line) { log(line); });
  if (!page) return tl::unexpected(page.error());
  router.set_page(std::move(*page));
  return {};
}

Result<void> Server::State::bind() {
  error_code error;
  tcp::resolver resolver(control);
  const auto found =
      resolver.resolve(options.host, std::to_string(options.port), tcp::resolver::passive, error);
  if (error) return tl::unexpected(io_failure("host " + options.host + ": " + error.message()));
  bound_port = options.port;
  error_code last_error;
  for (const auto& entry : found) {
    tcp::endpoint endpoint = entry.endpoint();
    endpoint.port(bound_port);
    Acceptor acceptor(control.get_executor());
    acceptor.open(endpoint.protocol(), error);
    if (!error) acceptor.set_option(asio::socket_base::reuse_address(true), error);
    if (!error && endpoint.address().is_v6()) {
      // "::" takes IPv4 as well; "localhost" has an address of either kind.
      acceptor.set_option(asio::ip::v6_only(!endpoint.address().is_unspecified()), error);
    }
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (error == asio::error::address_in_use || error == asio::error::access_denied) {
      return tl::unexpected(io_failure("port " + std::to_string(bound_port) + " of " +
                                       endpoint.address().to_string() + ": " + error.message() +
                                       ": choose another port, or 0 for a free one"));
    }
    if (error) {
      last_error = error;  // a host name's IPv6 address on a machine without IPv6, say
      continue;
    }
    bound_port = acceptor.local_endpoint(error).port();
    acceptors.push_back(std::move(acceptor));
  }
  if (!acceptors.empty()) return {};
  return tl::unexpected(
      io_failure("host " + options.host + ": cannot listen: " + last_error.message()));
}

Awaitable<void> Server::State::accept_on(Acceptor& acceptor) {
  asio::basic_waitable_timer<std::chrono::steady_clock,
                             asio::wait_traits<std::chrono::steady_clock>, Executor>
      pause(control.get_executor());
  while (!stopping) {
    Worker& worker = *workers[next_worker++ % workers.size()];
    Socket socket(worker.context().get_executor());
    tcp::endpoint peer;
    const auto [error] = co_await acceptor.async_accept(socket, peer, kAwait);
    if (stopping || error == asio::error::operation_aborted) co_return;
    if (error) {
      // Out of file descriptors, most likely: connections that end will free some.
      pause.expires_after(std::chrono::milliseconds(50));
      co_await pause.async_wait(kAwait);
      continue;
    }
    std::string address = address_key(peer.address());
    const Admission::Verdict verdict = admission.enter(address);
    if (verdict == Admission::Verdict::ignored) continue;
    worker.adopt(std::move(socket), std::move(address), verdict);
  }
}

void Server::State::wait_for_signal() {
  signals->async_wait([this](const error_code& error, int) {
    if (error) return;
    if (stopping) {
      drop_connections();
    } else {
      log("stopping: answers in flight end first");
      stop();
    }
    wait_for_signal();
  });
}

void Server::State::scan_regularly() {
  std::unique_lock lock(done_mutex);
  while (!done_changed.wait_for(lock, options.scan_interval, [this] { return stopping.load(); })) {
    lock.unlock();
    catalog.scan();
    if (!options.web_root.empty() && PageAssets::signature(options.web_root) != page_signature) {
      // While a build writes the page, parts of it may be missing: the old one stays until it
      // loads, and another change loads it again.
      if (const Result<void> loaded = load_page(); loaded) {
        log("page: loaded anew from " + options.web_root.string());
      } else {
        log(loaded.error().message);
      }
    }
    lock.lock();
  }
}

void Server::State::run() {
  uint32_t threads = options.threads;
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  for (uint32_t i = 0; i < threads; ++i) {
    workers.push_back(std::make_unique<Worker>(shared, admission));
  }
  workers_running = threads;
  for (const auto& worker : workers) {
    worker_threads.emplace_back([this, &worker = *worker] {
      worker.run();
      const std::lock_guard lock(done_mutex);
      if (--workers_running > 0) return;
      done_changed.notify_all();
      asio::post(control, [this] {
        if (signals) signals->cancel();
      });
    });
  }
  for (Acceptor& acceptor : acceptors) {
    asio::co_spawn(control, accept_on(acceptor), asio::detached);
  }
  if (options.handle_signals) {
    signals.emplace(control, SIGINT, SIGTERM);
    wait_for_signal();
  }
  control_thread = std::thread([this] { control.run(); });
  scan_thread = std::thread([this] { scan_regularly(); });
}

void Server::State::stop() {
  {
    const std::lock_guard lock(done_mutex);
    if (stopping.exchange(true)) return;
  }
  done_changed.notify_all();
  asio::post(control, [this] {
    error_code ignored;
    for (Acceptor& acceptor : acceptors) acceptor.close(ignored);
  });
  for (const auto& worker : workers) worker->stop();
}

void Server::State::drop_connections() {
  for (const auto& worker : workers) worker->abort();
}

Result<std::unique_ptr<Server>> Server::start(ServerOptions options) {
  for (const std::filesystem::path& source : options.stores) {
    std::error_code error;
    if (!std::filesystem::exists(source, error)) {
      return fail(Status::io_error,
                  source.string() +
                      ": no such file or folder: name stores that `isosplat build` "
                      "wrote, or a folder of them");
    }
  }
  if (options.scan_interval <= std::chrono::milliseconds(0) ||
      options.threads > kMaxServerThreads) {
    return fail(Status::invalid_argument,
                "server: expected a scan interval above 0 and at most 1024 threads");
  }
  raise_open_file_limit();
  auto state = std::make_unique<State>(std::move(options));
  if (Result<void> loaded = state->load_page(); !loaded) return tl::unexpected(loaded.error());
  if (Result<void> bound = state->bind(); !bound) return tl::unexpected(bound.error());
  state->catalog.scan();
  state->run();
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() = default;

uint16_t Server::port() const {
  return state_->bound_port;
}

std::string Server::url() const {
  std::string host = state_->options.host;
  if (host == "127.0.0.1" || host == "0.0.0.0" || host == "::" || host == "::1") host = "localhost";
  if (host.find(':') != std::string::npos) host = "[" + host + "]";
  return "http://" + host + ":" + std::to_string(state_->bound_port) + "/";
}

std::vector<Server::Volume> Server::volumes() const {
  std::vector<Volume> volumes;
  for (const auto& [name, entry] : *state_->catalog.snapshot()) {
    volumes.push_back({name, entry.path, entry.store ? entry.store->content() : "",
                       entry.error ? entry.error->message : ""});
  }
  return volumes;
}

void Server::stop() {
  state_->stop();
}

void Server::wait() {
  std::unique_lock lock(state_->done_mutex);
  state_->done_changed.wait(lock, [this] { return state_->workers_running == 0; });
}

}  // namespace isosplat
