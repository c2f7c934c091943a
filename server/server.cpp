#include "server/server.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <boost/asio/post.hpp>
#include <condition_variable>
#include <mutex>
#include <new>
#include <system_error>
#include <thread>
#include <utility>

#include "server/access/trusted_proxies.h"
#include "server/access_loader.h"
#include "server/access_options.h"
#include "server/capacity.h"
#include "server/catalog/catalog.h"
#include "server/catalog/scene_pool.h"
#include "server/catalog/store_pool.h"
#include "server/connection_shared.h"
#include "server/file_follower.h"
#include "server/limits/admission.h"
#include "server/limits/memory_limit.h"
#include "server/limits/work_pool.h"
#include "server/listeners.h"
#include "server/log/log_file.h"
#include "server/log/server_log.h"
#include "server/net/asio.h"
#include "server/net/tls.h"
#include "server/page_loader.h"
#include "server/routes/metrics.h"
#include "server/routes/router.h"
#include "server/signals.h"
#include "server/tls_loader.h"
#include "server/worker.h"

namespace isosplat::server {
namespace {

namespace asio = boost::asio;

/// Keep this number small, so that requests that read many headers queue behind each other instead
/// of delaying all other requests.
uint32_t header_threads(const ServerOptions& options) {
  return (options.disk_threads + 3) / 4;
}

Catalog::OutsideLinks outside_links(const ServerOptions& options) {
  return options.follow_outside_links ? Catalog::OutsideLinks::followed
                                      : Catalog::OutsideLinks::refused;
}

/// Half of the cores; connections and other programs use the rest.
uint32_t compute_threads() {
  return std::max(1u, std::thread::hardware_concurrency() / 2);
}

}  // namespace

struct Server::State {
  State(ServerOptions given, std::shared_ptr<LogFile> opened_access_file, TrustedProxies trusted)
      : options(std::move(given)),
        access_file(std::move(opened_access_file)),
        proxies(std::move(trusted)),
        log({options.log, options.log_file}, {options.access_log, access_file}),
        catalog(
            options.stores, [this](std::string_view line) { log.line(line); },
            outside_links(options)),
        stores(pool_limits(options.limits), [this](std::string_view line) { log.line(line); }),
        scenes({}, outside_links(options), [this](std::string_view line) { log.line(line); }),
        router(catalog, stores, scenes, router_limits(options.limits)),
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
        page(options.web_root, options.limits.page_asset_bytes, router, log),
        access(options, router, log, metrics, stopping),
        tls(options, log, metrics),
        files(options, catalog, stores, scenes, router, page, log, metrics, stopping),
        listeners(control, shared, admission, tls, workers),
        signals(control, options.limits, listeners, log, metrics, stopping,
                {.reload = [this] { return reload(); },
                 .stop = [this](std::chrono::milliseconds time) { stop(time); },
                 .stop_sooner = [this](std::chrono::milliseconds time) { stop_workers(time); },
                 .close_connections = [this] { close_connections(); }}) {
    router.set_monitor({&metrics, &stopping, &bytes_in_flight});
  }

  ~State() {
    stop(options.limits.stop_time);
    if (control_thread.joinable()) control_thread.join();
    access.join();
    files.join();
    for (std::thread& thread : worker_threads) thread.join();
    disk.join();
    headers.join();
    computing.join();
  }

  Result<void> choose_policy();
  Result<void> reload();
  bool has_files() const {
    return !options.token_file.empty() || !options.link_key_file.empty() ||
           !options.tls_certificate.empty() || access_file;
  }
  void run();
  void run_control();
  void stop(std::chrono::milliseconds time);
  void stop_workers(std::chrono::milliseconds time);
  void close_connections();

  const ServerOptions options;
  const std::shared_ptr<LogFile> access_file;  // null: none
  const TrustedProxies proxies;
  ServerLog log;
  std::atomic<bool> stopping{false};
  Catalog catalog;
  StorePool stores;
  ScenePool scenes;
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
  AccessLoader access;
  TlsLoader tls;
  FileFollower files;

  std::vector<std::unique_ptr<Worker>> workers;
  std::vector<std::thread> worker_threads;

  // Accepting and signals have a separate thread, so that they do not wait while workers read
  // files.
  asio::io_context control{1};
  Listeners listeners;
  Signals signals;
  std::thread control_thread;

  std::mutex done_mutex;
  std::condition_variable done_changed;
  size_t workers_running = 0;  // guarded by done_mutex
};

/// Determines the policy of origins. Call once the addresses are known.
Result<void> Server::State::choose_policy() {
  const bool is_local = listeners.is_local();
  Result<OriginPolicy> policy = origin_policy(options, is_local);
  if (!policy) return tl::unexpected(policy.error());
  router.set_policy(std::move(*policy));
  const bool has_tls = tls.context() != nullptr;
  if (!is_local && (!access.has_rules() || !has_tls)) {
    log.line(exposure_warning(options, listeners.port(), access.has_rules(), has_tls));
  }
  return {};
}

/// Reads each of them again. If one of them is invalid, keeps its previous value and still applies
/// the others.
Result<void> Server::State::reload() {
  std::vector<std::pair<std::string_view, Result<void>>> parts;
  parts.emplace_back("tokens and keys", access.load());
  if (!options.tls_certificate.empty()) parts.emplace_back("certificate", tls.load());
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
  access.want_keys();
  return first;
}

/// Runs the event loop for accepting and signals until it ends.
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
      asio::post(control, [this] { signals.cancel(); });
    });
  }
  listeners.start();
  if (options.handle_signals) signals.start(has_files());
  control_thread = std::thread([this] { run_control(); });
  files.start();
  access.start();
}

void Server::State::stop(std::chrono::milliseconds time) {
  if (stopping.exchange(true)) return;
  access.wake();
  files.wake();
  asio::post(control, [this] { listeners.close(); });
  stop_workers(time);
}

void Server::State::stop_workers(std::chrono::milliseconds time) {
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
  if (Result<void> loaded = state->access.prepare(); !loaded) return tl::unexpected(loaded.error());
  if (Result<void> loaded = state->tls.load(); !loaded) return tl::unexpected(loaded.error());
  if (Result<void> opened = state->listeners.open(state->options); !opened) {
    return tl::unexpected(opened.error());
  }
  const ServerOptions& chosen_options = state->options;
  const uint16_t port = state->listeners.port();
  state->router.set_https({chosen_options.hsts_seconds,
                           chosen_options.https_port != 0 ? chosen_options.https_port : port});
  state->router.set_cookie_name(chosen_options.cookie_name.empty()
                                    ? fmt::format("isosplat-{}", port)
                                    : chosen_options.cookie_name);
  if (Result<void> chosen = state->choose_policy(); !chosen) return tl::unexpected(chosen.error());
  if (const std::string warning = descriptor_warning(state->options.limits); !warning.empty()) {
    state->log.line(warning);
  }
  state->catalog.scan();
  state->router.count_files();
  state->run();
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() = default;

uint16_t Server::http_port() const {
  return state_->listeners.redirecting_port();
}

uint16_t Server::port() const {
  return state_->listeners.port();
}

std::string Server::url() const {
  std::string host = state_->options.host;
  if (host == "127.0.0.1" || host == "0.0.0.0" || host == "::" || host == "::1") host = "localhost";
  if (host.find(':') != std::string::npos) host = "[" + host + "]";
  return fmt::format("{}://{}:{}/", state_->tls.context() ? "https" : "http", host,
                     state_->listeners.port());
}

bool Server::has_stores() const {
  return !state_->catalog.snapshot()->empty() ||
         !state_->catalog.snapshot(ServedKind::scene)->empty();
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
