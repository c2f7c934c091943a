#include "server/server.h"

#include <fmt/format.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/posix/basic_stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <condition_variable>
#include <csignal>
#include <ctime>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

#include "server/access/ip_address.h"
#include "server/access/trusted_proxies.h"
#include "server/access_options.h"
#include "server/catalog/catalog.h"
#include "server/catalog/store_pool.h"
#include "server/connection.h"
#include "server/limits/admission.h"
#include "server/limits/memory_limit.h"
#include "server/limits/work_pool.h"
#include "server/log/log_file.h"
#include "server/log/server_log.h"
#include "server/net/asio.h"
#include "server/net/hand_over.h"
#include "server/net/http_get.h"
#include "server/net/listen.h"
#include "server/net/service_manager.h"
#include "server/net/tls.h"
#include "server/page_loader.h"
#include "server/routes/metrics.h"
#include "server/routes/refusals.h"
#include "server/routes/router.h"
#include "server/worker.h"

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;
using tcp = asio::ip::tcp;

/// Memory that the process must be able to allocate for another connection.
constexpr uint64_t kConnectionBytes = 256 << 10;

/// Raises the soft limit of open files to the hard limit: each store and each connection uses one.
/// Returns the limit.
uint64_t raise_open_file_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return UINT64_MAX;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
  ::getrlimit(RLIMIT_NOFILE, &limit);
  return limit.rlim_cur;
}

/// How many descriptors of the process stores and connections may use. The others are for its
/// threads that read headers, its logs, what it listens on, and refused connections.
uint64_t spare_descriptors() {
  constexpr uint64_t kOthers = 2 * uint64_t{Admission::kMostRefusals};
  const uint64_t all = raise_open_file_limit();
  return all - std::min(all / 2, kOthers);
}

StorePool::Limits pool_limits(const ServerLimits& limits) {
  const uint64_t most = std::max<uint64_t>(raise_open_file_limit() / 4, 1);
  return {static_cast<size_t>(std::min<uint64_t>(limits.open_stores, most)), limits.directory_bytes,
          limits.all_directory_bytes};
}

Admission::Limits admission_limits(const ServerLimits& limits) {
  const uint64_t most = spare_descriptors() - pool_limits(limits).stores;
  return {.connections = static_cast<uint32_t>(std::min<uint64_t>(limits.connections, most)),
          .per_address = limits.connections_per_address,
          .least_rate = limits.least_rate,
          .patience = limits.patience};
}

/// What the log says at the start if the system allows fewer open files than the limits need; else
/// nothing.
std::string descriptor_warning(const ServerLimits& limits) {
  const uint64_t stores = limits.open_stores, connections = limits.connections;
  const uint64_t spare = spare_descriptors();
  if (stores + connections <= spare) return {};
  return fmt::format(
      "the system allows {} open files, fewer than {} connections and {} open stores need ({}): "
      "the limits are now {} and {}. Raise it (ulimit -n, LimitNOFILE= of systemd), or lower them",
      raise_open_file_limit(), connections, stores,
      stores + connections + raise_open_file_limit() - spare, admission_limits(limits).connections,
      pool_limits(limits).stores);
}

RouterLimits router_limits(const ServerLimits& limits) {
  return {.query_bytes = limits.query_bytes,
          .query_chunks = limits.query_chunks,
          .query_directory_bytes = limits.query_directory_bytes,
          .target_bytes = limits.target_bytes};
}

/// The memory of bodies that one address may take. A proxy's address is that of all clients.
uint64_t bytes_of_one(const ServerLimits& limits) {
  return limits.connections_per_address == 0 ? UINT64_MAX : limits.bytes_in_flight / 4;
}

/// A text for a line of systemd's protocol.
std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

/// Few: requests that read many headers wait for each other then, and others do not.
uint32_t header_threads(const ServerOptions& options) {
  return (options.disk_threads + 3) / 4;
}

/// Half of the cores: connections and other programs keep the others.
uint32_t compute_threads() {
  return std::max(1u, std::thread::hardware_concurrency() / 2);
}

}  // namespace

struct Server::State {
  State(ServerOptions given, std::shared_ptr<LogFile> its_access_file, TrustedProxies its_proxies)
      : options(std::move(given)),
        access_file(std::move(its_access_file)),
        proxies(std::move(its_proxies)),
        log({options.log, options.log_file}, {options.access_log, access_file}),
        catalog(
            options.stores, [this](std::string_view line) { log.line(line); },
            options.follow_outside_links ? Catalog::OutsideLinks::followed
                                         : Catalog::OutsideLinks::refused),
        stores(pool_limits(options.limits), [this](std::string_view line) { log.line(line); }),
        router(catalog, stores, router_limits(options.limits)),
        admission(admission_limits(options.limits)),
        disk({.threads = options.disk_threads}, {metrics.reads_of_disk, metrics.reads_waiting}),
        headers({.threads = header_threads(options)},
                {metrics.reads_of_disk, metrics.reads_waiting}),
        computing({.threads = compute_threads(),
                   .waiting = options.limits.waiting_computations,
                   .waiting_of_one = options.limits.waiting_computations_of_one},
                  {metrics.computations, metrics.computations_waiting}),
        rates({options.limits.requests_per_second, options.limits.bytes_per_second}),
        bytes_in_flight(options.limits.bytes_in_flight, bytes_of_one(options.limits)),
        shared{router,
               options.limits,
               stopping,
               log,
               disk,
               headers,
               computing,
               metrics,
               rates,
               bytes_in_flight,
               options.log_format,
               proxies,
               !options.tls_certificate.empty()},
        page(options.web_root, options.limits.page_asset_bytes, router, log) {
    router.set_monitor({&metrics, &stopping, &bytes_in_flight});
  }

  ~State() {
    stop(options.limits.stop_time);
    if (control_thread.joinable()) control_thread.join();
    if (key_thread.joinable()) key_thread.join();
    if (scan_thread.joinable()) scan_thread.join();
    for (std::thread& thread : worker_threads) thread.join();
    disk.join();
    headers.join();
    computing.join();
  }

  Result<void> choose_policy();
  Result<void> load_access();
  Result<void> load_tls_files();
  std::shared_ptr<TlsContext> tls_context();
  Result<void> reload();
  bool has_files() const {
    return !options.token_file.empty() || !options.link_key_file.empty() ||
           !options.tls_certificate.empty() || access_file;
  }
  void run();
  bool fetch_keys();
  void follow_keys();
  Awaitable<void> accept_on(Acceptor& acceptor, bool has_tls);
  void admit(Worker& worker, Socket socket, const tcp::endpoint& peer, bool has_tls);
  void run_control();
  void wait_for_signal();
  void handle_signal(int signal);
  void follow_files();
  void follow_files_to_end();
  bool read_headers(const CatalogSnapshot& snapshot, std::string& done);
  void hand_over();
  Awaitable<void> await_successor(Successor successor);
  void stop(std::chrono::milliseconds time);
  void close_connections();

  const ServerOptions options;
  const std::shared_ptr<LogFile> access_file;  // null: none
  const TrustedProxies proxies;
  ServerLog log;
  std::atomic<bool> stopping{false};
  Catalog catalog;
  StorePool stores;
  Router router;
  Admission admission;
  Metrics metrics;
  WorkPool disk;
  WorkPool headers;
  WorkPool computing;
  RateLimit rates;
  ByteBudget bytes_in_flight;
  ConnectionShared shared;
  PageLoader page;
  uint16_t bound_port = 0;
  std::atomic<bool> has_access_rules{false};
  std::mutex tls_mutex;
  std::shared_ptr<TlsContext> tls;  // guarded by tls_mutex; null without TLS

  std::vector<std::unique_ptr<Worker>> workers;
  std::vector<std::thread> worker_threads;
  std::atomic<size_t> next_worker{0};

  // Accepting and signals have their own thread, so that they do not wait while workers read files.
  asio::io_context control{1};
  std::vector<Acceptor> acceptors;
  std::vector<Acceptor> plain_acceptors;  // only redirect to https
  std::optional<asio::signal_set> signals;
  bool has_successor = false;   // that is starting; of the control thread, as the next one
  bool is_handed_over = false;  // and responses in progress are completed
  std::thread control_thread;
  std::thread scan_thread;
  std::thread key_thread;  // of follow_keys()

  std::mutex done_mutex;
  std::condition_variable done_changed;
  size_t workers_running = 0;    // guarded by done_mutex
  bool are_keys_wanted = false;  // guarded by done_mutex
  std::mutex access_mutex;
  std::string fetched_keys;  // guarded by access_mutex
};

/// Decides who may read the data. Call when the addresses are known.
Result<void> Server::State::choose_policy() {
  const bool is_local = std::ranges::all_of(acceptors, [](const Acceptor& acceptor) {
    error_code error;
    return acceptor.local_endpoint(error).address().is_loopback() && !error;
  });
  Result<OriginPolicy> policy = origin_policy(options, is_local);
  if (!policy) return tl::unexpected(policy.error());
  router.set_policy(std::move(*policy));
  if (!is_local && (!has_access_rules || !tls)) {
    log.line(exposure_warning(options, bound_port, has_access_rules, tls != nullptr));
  }
  return {};
}

Result<void> Server::State::load_access() {
  const std::lock_guard lock(access_mutex);
  auto rules = read_access(options, fetched_keys);
  if (!rules) return tl::unexpected(rules.error());
  for (const std::string& warning : secret_file_warnings(options)) log.line(warning);
  has_access_rules = !(*rules)->is_open();
  router.set_access(std::move(*rules));
  return {};
}

/// Reads certificate and key, for the connections that follow.
Result<void> Server::State::load_tls_files() {
  if (options.tls_certificate.empty() && options.tls_key.empty()) return {};
  auto loaded = load_tls(options.tls_certificate, options.tls_key);
  if (!loaded) return tl::unexpected(loaded.error());
  const int64_t end = certificate_end(**loaded);
  metrics.certificate_end = end;
  constexpr int64_t kDay = 24 * 3600, kWarned = 14 * kDay;
  const int64_t left = end - std::time(nullptr);
  if (left < kWarned) {
    log.line(left < 0
                 ? fmt::format("warning: {}: the certificate has ended: clients will refuse it",
                               options.tls_certificate.string())
                 : fmt::format("warning: {}: the certificate ends in {} days: renew it",
                               options.tls_certificate.string(), left / kDay));
  }
  const std::lock_guard lock(tls_mutex);
  tls = std::move(*loaded);
  return {};
}

std::shared_ptr<TlsContext> Server::State::tls_context() {
  const std::lock_guard lock(tls_mutex);
  return tls;
}

/// Fetches the keys of the identity provider, and uses them. False if that failed: those from
/// before stay.
bool Server::State::fetch_keys() {
  const auto answer = http_get(options.jwt_keys, {.timeout = std::chrono::seconds(5)});
  std::string problem;
  if (!answer) {
    problem = answer.error().message;
  } else if (answer->status != 200) {
    problem = fmt::format("{}: status {}", options.jwt_keys, answer->status);
  } else {
    const std::lock_guard lock(access_mutex);
    if (answer->body == fetched_keys) return true;
    const auto verifier = JwtVerifier::create(answer->body, options.jwt);
    if (verifier) {
      fetched_keys = answer->body;
    } else {
      problem = fmt::format("{}: {}", options.jwt_keys, verifier.error().message);
    }
  }
  if (problem.empty()) {
    const Result<void> loaded = load_access();
    if (loaded) {
      log.line(fmt::format("{}: keys of the identity provider: read", options.jwt_keys));
      return true;
    }
    problem = loaded.error().message;
  }
  log.line(fmt::format("keys of the identity provider: those from before stay: {}", problem));
  return false;
}

/// Fetches the keys regularly, until the server stops: an identity provider publishes a new key
/// some time before it signs with it.
void Server::State::follow_keys() {
  bool is_fetched = true;  // Server::start() has tried
  while (!stopping) {
    std::unique_lock lock(done_mutex);
    done_changed.wait_for(lock, is_fetched ? std::chrono::minutes(5) : std::chrono::seconds(30),
                          [this] { return stopping || are_keys_wanted; });
    are_keys_wanted = false;
    lock.unlock();
    try {
      if (!stopping) is_fetched = fetch_keys();
    } catch (const std::bad_alloc&) {
      ++metrics.out_of_memory;
      is_fetched = false;
    }
  }
}

/// Reads each of them again. Those that are wrong stay as they were, whatever becomes of the
/// others.
Result<void> Server::State::reload() {
  std::vector<std::pair<std::string_view, Result<void>>> parts;
  parts.emplace_back("tokens and keys", load_access());
  if (!options.tls_certificate.empty()) parts.emplace_back("certificate", load_tls_files());
  if (access_file) parts.emplace_back("access log", access_file->reopen());
  Result<void> first;
  for (const auto& [name, loaded] : parts) {
    if (loaded) continue;
    log.line(
        fmt::format("{}: not read again, the old ones stay: {}", name, loaded.error().message));
    if (first) first = loaded;
  }
  for (const auto& [name, loaded] : parts) {
    if (!first && loaded) log.line(fmt::format("{}: opened again", name));
  }
  if (first) log.line("tokens, keys, certificates and logs: opened again");
  metrics.add_reload(first.has_value());
  {
    const std::lock_guard lock(done_mutex);
    are_keys_wanted = true;
  }
  done_changed.notify_all();
  return first;
}

Awaitable<void> Server::State::accept_on(Acceptor& acceptor, bool has_tls) {
  Timer pause(control.get_executor());
  while (!stopping) {
    Worker& worker = *workers[next_worker++ % workers.size()];
    Socket socket(worker.context().get_executor());
    tcp::endpoint peer;
    const auto [error] = co_await acceptor.async_accept(socket, peer, kAwait);
    if (stopping || error == asio::error::operation_aborted) co_return;
    bool is_served = false;
    try {
      is_served = !error && has_memory_for(kConnectionBytes);
      if (is_served) admit(worker, std::move(socket), peer, has_tls);
      // Most likely out of file descriptors or memory: connections that end will free some.
      if (!is_served) admission.make_room(std::chrono::steady_clock::now());
    } catch (const std::bad_alloc&) {
      is_served = false;
    }
    if (is_served) continue;
    if (!error) ++metrics.out_of_memory;
    error_code ignored;
    socket.close(ignored);
    pause.expires_after(std::chrono::milliseconds(10));
    co_await pause.async_wait(kAwait);
  }
}

/// Gives a connection to a worker, or refuses it.
void Server::State::admit(Worker& worker, Socket socket, const tcp::endpoint& peer, bool has_tls) {
  const IpAddress peer_address = IpAddress::of(*peer.data()).value_or(IpAddress{});
  const bool is_of_proxy = proxies.trusts(peer_address);
  auto place = admission.enter(is_of_proxy ? Admission::kOfProxy : peer_address.client_key(),
                               std::chrono::steady_clock::now());
  if (!place) {
    ++metrics.connections_refused;
    if (log.has_access_log()) {
      log.access(refusal_line(options.log_format, peer_address.client_key(), 0, 0));
    }
    return;
  }
  worker.adopt(std::move(socket), std::move(place), has_tls ? tls_context() : nullptr);
}

/// Runs the event loop of accepting and signals to its end.
void Server::State::run_control() {
  while (true) {
    try {
      control.run();
      return;
    } catch (const std::bad_alloc&) {
      ++metrics.out_of_memory;
    }
  }
}

void Server::State::wait_for_signal() {
  signals->async_wait([this](const error_code& error, int signal) {
    if (error) return;
    try {
      handle_signal(signal);
    } catch (const std::bad_alloc&) {
      ++metrics.out_of_memory;
    }
    wait_for_signal();
  });
}

void Server::State::handle_signal(int signal) {
  if (signal == SIGHUP) {
    notify_reloading();
    const Result<void> reloaded = reload();
    notify_service_manager(reloaded ? "READY=1\nSTATUS=Reloaded."
                                    : "READY=1\nSTATUS=Reload failed: " +
                                          one_line(reloaded.error().message));
  } else if (signal == SIGUSR2) {
    hand_over();
  } else if (is_handed_over) {
    is_handed_over = false;
    for (const auto& worker : workers) worker->stop(options.limits.stop_time);
  } else if (stopping) {
    close_connections();
  } else {
    log.line("stopping: responses in progress are completed first");
    notify_service_manager("STOPPING=1");
    stop(options.limits.stop_time);
  }
}

/// Follows what happens to stores and page, until the server stops.
void Server::State::follow_files() {
  using Clock = std::chrono::steady_clock;
  Clock::time_point next = Clock::now();
  std::string read_up_to;
  bool are_headers_read = false;
  while (!stopping) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(next - Clock::now());
    const bool has_changed = catalog.follow(
        are_headers_read ? std::clamp(left, {}, options.scan_interval) : decltype(left){0});
    const auto snapshot = catalog.snapshot();
    if (has_changed) {
      read_up_to.clear();
      are_headers_read = false;
    }
    if (!are_headers_read) are_headers_read = read_headers(*snapshot, read_up_to);
    if (Clock::now() < next && !has_changed) continue;
    stores.trim(*snapshot);
    if (Clock::now() < next) continue;
    router.count_volumes();
    page.load_if_changed();
    metrics.log_dropped = log.dropped();
    metrics.access_log_dropped = log.access_dropped();
    next = Clock::now() + options.scan_interval;
  }
}

/// The same, and again after what it lacked memory for.
void Server::State::follow_files_to_end() {
  while (!stopping) {
    try {
      follow_files();
    } catch (const std::bad_alloc&) {
      ++metrics.out_of_memory;
      std::this_thread::sleep_for(options.scan_interval);
    }
  }
}

/// Reads headers that nobody has read yet, so that searches find titles at once and the log names
/// stores that cannot be served. For a moment only: returns whether all were read. `done`: the name
/// up to which the last call came.
bool Server::State::read_headers(const CatalogSnapshot& snapshot, std::string& done) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + std::chrono::milliseconds(50);
  for (auto item = done.empty() ? snapshot.begin() : snapshot.upper_bound(done);
       item != snapshot.end(); ++item) {
    if (stopping || Clock::now() > end) return false;
    stores.summary(*item->second);
    done = item->first;
  }
  done.clear();
  return true;
}

void Server::State::run() {
  uint32_t threads = options.threads;
  if (threads == 0) threads = std::max(1u, std::thread::hardware_concurrency());
  for (uint32_t i = 0; i < threads; ++i) {
    workers.push_back(std::make_unique<Worker>(shared));
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
    asio::co_spawn(control, accept_on(acceptor, true), asio::detached);
  }
  for (Acceptor& acceptor : plain_acceptors) {
    asio::co_spawn(control, accept_on(acceptor, false), asio::detached);
  }
  if (options.handle_signals) {
    signals.emplace(control);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR2}) {
      // Without files to read again, SIGHUP ends the program: its terminal was closed. systemd
      // sends it to reload.
      if (signal == SIGHUP && !has_files() && !has_service_manager()) continue;
      struct sigaction now {};
      // Ignored signals stay ignored: a shell ignores SIGINT for its background jobs.
      if (::sigaction(signal, nullptr, &now) == 0 && now.sa_handler != SIG_IGN) {
        signals->add(signal);
      }
    }
    wait_for_signal();
  }
  control_thread = std::thread([this] { run_control(); });
  scan_thread = std::thread([this] { follow_files_to_end(); });
  if (is_address(options.jwt_keys)) key_thread = std::thread([this] { follow_keys(); });
}

/// Starts a new process with the listening sockets, and stops when that is ready.
void Server::State::hand_over() {
  if (stopping || has_successor) {
    log.line("hand-over: this process is already stopping or handing over");
    return;
  }
  ListeningSockets sockets;
  for (Acceptor& acceptor : acceptors) sockets.serving.push_back(acceptor.native_handle());
  for (Acceptor& acceptor : plain_acceptors) {
    sockets.redirecting.push_back(acceptor.native_handle());
  }
  const Result<Successor> successor = start_successor(sockets);
  if (!successor) {
    log.line("hand-over: this process goes on: " + successor.error().message);
    return;
  }
  has_successor = true;
  asio::co_spawn(control, await_successor(*successor), asio::detached);
}

Awaitable<void> Server::State::await_successor(Successor successor) {
  asio::posix::basic_stream_descriptor<Executor> ready(control.get_executor(), successor.ready);
  char byte = 0;
  const auto [error, bytes] = co_await ready.async_read_some(asio::buffer(&byte, 1), kAwait);
  has_successor = false;
  if (error || stopping) {
    if (error) {
      log.line("hand-over: this process goes on: the new one did not start");
    } else {
      ::kill(successor.process, SIGTERM);  // as this one was told
    }
    ::waitpid(successor.process, nullptr, 0);
    co_return;
  }
  log.line(fmt::format("handed over to process {}: responses in progress are completed here",
                       successor.process));
  notify_service_manager(fmt::format("MAINPID={}", successor.process));
  is_handed_over = true;
  stop(options.limits.hand_over_time);
}

void Server::State::stop(std::chrono::milliseconds time) {
  {
    const std::lock_guard lock(done_mutex);
    if (stopping.exchange(true)) return;
  }
  done_changed.notify_all();
  catalog.wake();
  asio::post(control, [this] {
    error_code ignored;
    for (auto* each : {&acceptors, &plain_acceptors}) {
      for (Acceptor& acceptor : *each) acceptor.close(ignored);
    }
  });
  for (const auto& worker : workers) worker->stop(time);
}

void Server::State::close_connections() {
  for (const auto& worker : workers) worker->abort();
}

namespace {

Result<void> check_numbers_and_paths(const ServerOptions& options) {
  for (const std::filesystem::path& source : options.stores) {
    std::error_code error;
    if (!std::filesystem::exists(source, error)) {
      return fail(Status::io_error,
                  fmt::format("{}: no such file or folder: expected a store from `isosplat build`, "
                              "or a folder of stores",
                              source.string()));
    }
  }
  if (options.scan_interval <= std::chrono::milliseconds(0) ||
      options.threads > kMaxServerThreads || options.disk_threads < 1 ||
      options.disk_threads > kMaxServerThreads) {
    return fail(Status::invalid_argument,
                "server: expected a scan interval above 0, at most 1024 threads, and 1 to 1024 "
                "threads for disks");
  }
  const bool has_tls = !options.tls_certificate.empty() || !options.tls_key.empty();
  if (options.http_port && !has_tls) {
    return fail(Status::invalid_argument,
                "redirection to https: expected a certificate: this server has no TLS");
  }
  if (options.hsts_seconds > 0 && !has_tls && options.trusted_proxies.empty()) {
    return fail(Status::invalid_argument,
                "Strict-Transport-Security: expected a certificate, or a trusted proxy with TLS");
  }
  return {};
}

}  // namespace

Result<void> Server::check(const ServerOptions& options) {
  Result<void> valid = check_numbers_and_paths(options);
  if (!valid) return valid;
  const auto proxies = TrustedProxies::parse(options.trusted_proxies, options.proxy_fields);
  if (!proxies) return tl::unexpected(proxies.error());
  const auto rules = read_access(options, {});
  if (!rules) return tl::unexpected(rules.error());
  if (options.tls_certificate.empty() && options.tls_key.empty()) return {};
  const auto tls = load_tls(options.tls_certificate, options.tls_key);
  if (!tls) return tl::unexpected(tls.error());
  return {};
}

Result<std::unique_ptr<Server>> Server::start(ServerOptions options) {
  if (Result<void> valid = check_numbers_and_paths(options); !valid) {
    return tl::unexpected(valid.error());
  }
  auto proxies = TrustedProxies::parse(options.trusted_proxies, options.proxy_fields);
  if (!proxies) {
    return fail(proxies.error().status, "trusted proxies: " + proxies.error().message);
  }
  std::shared_ptr<LogFile> access_file;
  if (!options.access_log_file.empty()) {
    auto opened = LogFile::open(options.access_log_file);
    if (!opened) return tl::unexpected(opened.error());
    access_file = std::move(*opened);
  }
  prepare_for_memory_limit();
  auto state =
      std::make_unique<State>(std::move(options), std::move(access_file), std::move(*proxies));
  if (Result<void> loaded = state->page.load(); !loaded) return tl::unexpected(loaded.error());
  if (Result<void> loaded = state->load_access(); !loaded) return tl::unexpected(loaded.error());
  if (is_address(state->options.jwt_keys)) state->are_keys_wanted = !state->fetch_keys();
  if (Result<void> loaded = state->load_tls_files(); !loaded) {
    return tl::unexpected(loaded.error());
  }
  auto acceptors = state->options.sockets.empty()
                       ? listen(state->control, state->options.host, state->options.port)
                       : take_over(state->control, state->options.sockets);
  if (!acceptors) return tl::unexpected(acceptors.error());
  state->acceptors = std::move(*acceptors);
  state->bound_port = state->acceptors.front().local_endpoint().port();
  const ServerOptions& chosen_options = state->options;
  if (!chosen_options.http_port) {
    // Its predecessor had the port, its configuration has changed.
    for (const int socket : chosen_options.redirecting_sockets) ::close(socket);
  } else {
    auto plain = chosen_options.redirecting_sockets.empty()
                     ? listen(state->control, chosen_options.host, *chosen_options.http_port)
                     : take_over(state->control, chosen_options.redirecting_sockets);
    if (!plain) return tl::unexpected(plain.error());
    state->plain_acceptors = std::move(*plain);
  }
  state->router.set_https({chosen_options.hsts_seconds, chosen_options.https_port != 0
                                                            ? chosen_options.https_port
                                                            : state->bound_port});
  state->router.set_cookie_name(chosen_options.cookie_name.empty()
                                    ? fmt::format("isosplat-{}", state->bound_port)
                                    : chosen_options.cookie_name);
  if (Result<void> chosen = state->choose_policy(); !chosen) return tl::unexpected(chosen.error());
  if (const std::string warning = descriptor_warning(state->options.limits); !warning.empty()) {
    state->log.line(warning);
  }
  state->catalog.scan();
  state->router.count_volumes();
  state->run();
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() = default;

uint16_t Server::http_port() const {
  if (state_->plain_acceptors.empty()) return 0;
  error_code error;
  return state_->plain_acceptors.front().local_endpoint(error).port();
}

uint16_t Server::port() const {
  return state_->bound_port;
}

std::string Server::url() const {
  std::string host = state_->options.host;
  if (host == "127.0.0.1" || host == "0.0.0.0" || host == "::" || host == "::1") host = "localhost";
  if (host.find(':') != std::string::npos) host = "[" + host + "]";
  return fmt::format("{}://{}:{}/", state_->tls_context() ? "https" : "http", host,
                     state_->bound_port);
}

bool Server::has_stores() const {
  return !state_->catalog.snapshot()->empty();
}

std::vector<Server::Volume> Server::volumes() const {
  const std::shared_ptr<const CatalogSnapshot> snapshot = state_->catalog.snapshot();
  std::vector<Volume> volumes;
  for (const auto& [name, entry] : *snapshot) {
    const auto summary = state_->stores.summary(*entry);
    volumes.push_back(
        {name, entry->path, summary->content, summary->error ? summary->error->message : ""});
  }
  return volumes;
}

Result<void> Server::reload() {
  return state_->reload();
}

void Server::stop() {
  state_->stop(state_->options.limits.stop_time);
}

void Server::wait() {
  std::unique_lock lock(state_->done_mutex);
  state_->done_changed.wait(lock, [this] { return state_->workers_running == 0; });
}

}  // namespace isosplat::server
