#include "server/routes/metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <string_view>

#include "server/limits/byte_budget.h"
#include "server/routes/process_metrics.h"
#include "server/routes/routes.h"

namespace isosplat::server {
namespace {

// No memory order is needed, since the counters guard no other data.
constexpr auto kRelaxed = std::memory_order_relaxed;

void declare(std::string& text, std::string_view name, std::string_view type,
             std::string_view help) {
  fmt::format_to(std::back_inserter(text), "# HELP {0} {2}\n# TYPE {0} {1}\n", name, type, help);
}

void add_value(std::string& text, std::string_view name, std::string_view type,
               std::string_view help, uint64_t value) {
  declare(text, name, type, help);
  fmt::format_to(std::back_inserter(text), "{} {}\n", name, value);
}

std::string_view label_of(size_t route) {
  return route < routes().size() ? routes()[route].pattern : "none";
}

}  // namespace

Metrics::Metrics() : per_route_(routes().size() + 1) {
  reload_time = std::chrono::system_clock::to_time_t(start_);
}

void Metrics::add_response(size_t route, int status, uint64_t bytes,
                           std::chrono::nanoseconds time) {
  PerRoute& counters = per_route_[std::min(route, per_route_.size() - 1)];
  const auto microseconds = static_cast<uint64_t>(
      std::max<int64_t>(std::chrono::ceil<std::chrono::microseconds>(time).count(), 0));
  const auto bucket = std::ranges::lower_bound(kBuckets, microseconds) - kBuckets.begin();
  counters.by_status[static_cast<size_t>(std::clamp(status, 0, kMaxStatus))].fetch_add(1, kRelaxed);
  counters.by_time[static_cast<size_t>(bucket)].fetch_add(1, kRelaxed);
  counters.microseconds.fetch_add(microseconds, kRelaxed);
  counters.bytes.fetch_add(bytes, kRelaxed);
}

void Metrics::add_reload(bool is_successful) {
  ++(is_successful ? reloads : reloads_failed);
  was_reload_successful = is_successful;
  reload_time = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
}

std::string Metrics::text(const StoreCounts& stores, const StoreCounts& scenes,
                          const ByteBudget* bytes_in_flight) const {
  std::string text;
  const auto out = std::back_inserter(text);
  // Routes without a request so far are left out.
  const auto used = [&](const PerRoute& route) {
    return std::ranges::any_of(route.by_status, [](const auto& count) { return count != 0; });
  };
  constexpr std::string_view kRequests = "isosplat_http_requests_total";
  declare(text, kRequests, "counter", "Responses, by route and status.");
  for (size_t i = 0; i < per_route_.size(); ++i) {
    for (int status = 0; status <= kMaxStatus; ++status) {
      const uint64_t count = per_route_[i].by_status[static_cast<size_t>(status)];
      if (count == 0) continue;
      fmt::format_to(out, "{}{{route=\"{}\",status=\"{}\"}} {}\n", kRequests, label_of(i), status,
                     count);
    }
  }
  constexpr std::string_view kBytes = "isosplat_http_response_body_bytes_total";
  declare(text, kBytes, "counter", "Bytes of bodies that were sent, by route.");
  for (size_t i = 0; i < per_route_.size(); ++i) {
    if (!used(per_route_[i])) continue;
    fmt::format_to(out, "{}{{route=\"{}\"}} {}\n", kBytes, label_of(i), per_route_[i].bytes.load());
  }
  constexpr std::string_view kSeconds = "isosplat_http_request_duration_seconds";
  declare(text, kSeconds, "histogram",
          "From the last byte of a request to the last byte that was sent, by route.");
  for (size_t i = 0; i < per_route_.size(); ++i) {
    if (!used(per_route_[i])) continue;
    uint64_t count = 0;
    for (size_t bucket = 0; bucket <= kBuckets.size(); ++bucket) {
      count += per_route_[i].by_time[bucket];
      const std::string limit =
          bucket == kBuckets.size() ? "+Inf" : fmt::format("{}", kBuckets[bucket] * 1e-6);
      fmt::format_to(out, "{}_bucket{{route=\"{}\",le=\"{}\"}} {}\n", kSeconds, label_of(i), limit,
                     count);
    }
    fmt::format_to(out, "{0}_sum{{route=\"{1}\"}} {2:.6f}\n{0}_count{{route=\"{1}\"}} {3}\n",
                   kSeconds, label_of(i), static_cast<double>(per_route_[i].microseconds) * 1e-6,
                   count);
  }
  add_value(text, "isosplat_connections_total", "counter", "Connections that were admitted.",
            connections);
  add_value(text, "isosplat_connections_refused_total", "counter", "Connections above a limit.",
            connections_refused);
  add_value(text, "isosplat_connections_closed_total", "counter",
            "Connections that made little progress and were closed for others.",
            connections_closed);
  add_value(text, "isosplat_connections_open", "gauge", "Open connections.", connections_open);
  if (bytes_in_flight) {
    add_value(text, "isosplat_bytes_in_flight", "gauge", "Memory of bodies that are being sent.",
              bytes_in_flight->used());
    add_value(text, "isosplat_bytes_in_flight_limit", "gauge", "The most of it.",
              bytes_in_flight->limit());
  }
  add_value(text, "isosplat_tls_failures_total", "counter",
            "TLS handshakes that failed, or were not complete in time.", tls_failures);
  if (certificate_end != 0) {
    add_value(text, "isosplat_tls_certificate_end_seconds", "gauge",
              "When the certificate ends, in seconds since 1970.",
              static_cast<uint64_t>(std::max<int64_t>(certificate_end, 0)));
  }
  constexpr std::string_view kReloads = "isosplat_reloads_total";
  declare(text, kReloads, "counter", "Reloads of tokens, keys and certificates.");
  fmt::format_to(out, "{0}{{result=\"success\"}} {1}\n{0}{{result=\"failure\"}} {2}\n", kReloads,
                 reloads.load(), reloads_failed.load());
  add_value(text, "isosplat_last_reload_successful", "gauge",
            "1 if the last reload, or else the start, read all of them.", was_reload_successful);
  add_value(text, "isosplat_last_reload_seconds", "gauge", "When that was, in seconds since 1970.",
            static_cast<uint64_t>(reload_time.load()));
  constexpr std::string_view kReads = "isosplat_reads_total";
  declare(text, kReads, "counter",
          "Requests, and pieces of bodies, whose bytes were in memory or were read from a disk.");
  fmt::format_to(out, "{0}{{from=\"memory\"}} {1}\n{0}{{from=\"disk\"}} {2}\n", kReads,
                 reads_in_memory.load(), reads_of_disk.load());
  add_value(text, "isosplat_disk_reads_waiting", "gauge",
            "Requests that wait for a disk, or for a thread that may.", reads_waiting);
  add_value(text, "isosplat_computations_total", "counter",
            "Turns of requests, and pieces of bodies, that the threads that compute have begun.",
            computations);
  add_value(text, "isosplat_computations_waiting", "gauge",
            "Requests that are computed, or wait for a thread that computes.",
            computations_waiting);
  add_value(text, "isosplat_computations_refused_total", "counter",
            "Requests that were refused because too many waited.", computations_refused);
  add_value(text, "isosplat_work_cancelled_total", "counter",
            "Requests whose client left while a disk was read or points were computed for it.",
            work_cancelled);
  const auto add_states = [&](std::string_view name, std::string_view help,
                              const StoreCounts& counts) {
    declare(text, name, "gauge", help);
    fmt::format_to(out,
                   "{0}{{state=\"served\"}} {1}\n{0}{{state=\"broken\"}} {2}\n"
                   "{0}{{state=\"unread\"}} {3}\n",
                   name, counts.served, counts.broken, counts.unread);
  };
  add_states("isosplat_stores",
             "Stores that are served, those that cannot be, and those that were not looked at yet.",
             stores);
  add_states("isosplat_scenes", "The same of scenes.", scenes);
  add_value(text, "isosplat_scenes_open", "gauge", "Scenes that are open.", scenes.open);
  add_value(text, "isosplat_stores_open", "gauge", "Stores that are open.", stores.open);
  add_value(text, "isosplat_stores_opened_total", "counter",
            "How often a store was opened for a request.", stores.opened);
  add_value(text, "isosplat_out_of_memory_total", "counter",
            "Requests and connections that failed for lack of memory.", out_of_memory);
  add_value(text, "isosplat_faults_total", "counter",
            "Errors of the server or its disks, not of clients.", faults);
  constexpr std::string_view kDropped = "isosplat_log_lines_dropped_total";
  declare(text, kDropped, "counter", "Lines of the logs that were not written.");
  fmt::format_to(out, "{0}{{log=\"server\"}} {1}\n{0}{{log=\"access\"}} {2}\n", kDropped,
                 log_dropped.load(), access_log_dropped.load());
  const auto start = std::chrono::floor<std::chrono::seconds>(start_).time_since_epoch();
  add_value(text, "process_start_time_seconds", "gauge", "Start, in seconds since 1970.",
            static_cast<uint64_t>(start.count()));
  add_process_metrics(text);
  return text;
}

}  // namespace isosplat::server
