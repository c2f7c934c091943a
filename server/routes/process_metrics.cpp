#include "server/routes/process_metrics.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

namespace isosplat::server {
namespace {

void add(std::string& text, std::string_view name, std::string_view type, std::string_view help,
         const std::string& value, std::string_view labels = {}) {
  fmt::format_to(std::back_inserter(text), "# HELP {0} {2}\n# TYPE {0} {1}\n{0}{4} {3}\n", name,
                 type, help, value, labels);
}

void add_memory(std::string& text) {
  std::ifstream file("/proc/self/statm");
  uint64_t total = 0, resident = 0;  // pages
  if (!(file >> total >> resident)) return;
  const auto page = static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
  add(text, "process_virtual_memory_bytes", "gauge", "Addresses in use, in bytes.",
      std::to_string(total * page));
  add(text, "process_resident_memory_bytes", "gauge", "Memory in use, in bytes.",
      std::to_string(resident * page));
}

void add_descriptors(std::string& text) {
  std::error_code error;
  uint64_t count = 0;
  for (std::filesystem::directory_iterator entry("/proc/self/fd", error), end;
       !error && entry != end; entry.increment(error)) {
    ++count;
  }
  if (!error && count > 0) {
    add(text, "process_open_fds", "gauge", "Open file descriptors.",
        std::to_string(count - 1));  // without the descriptor of the iterator
  }
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  add(text, "process_max_fds", "gauge", "Limit of open file descriptors.",
      std::to_string(limit.rlim_cur));
}

void add_processor_time(std::string& text) {
  rusage usage{};
  if (::getrusage(RUSAGE_SELF, &usage) != 0) return;
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  add(text, "process_cpu_seconds_total", "counter",
      "Processor time, of user and system, in seconds.",
      fmt::format("{:.6f}", seconds(usage.ru_utime) + seconds(usage.ru_stime)));
}

}  // namespace

void add_process_metrics(std::string& text) {
  add(text, "isosplat_build_info", "gauge", "1; the labels say which program this is.", "1",
      "{version=\"" ISOSPLAT_VERSION "\",compiler=\"" __VERSION__ "\"}");
  add_memory(text);
  add_descriptors(text);
  add_processor_time(text);
}

}  // namespace isosplat::server
