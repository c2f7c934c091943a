#include "native/cli/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "native/cli/command.h"
#include "server/http/printable_text.h"

namespace isosplat::cli {
namespace {

bool quiet = false;

/// Prints a line on the standard error. Ignores failures, since a full disk there is not an error
/// of the command.
void print_line(const char* prefix, std::string_view text) {
  const std::string line = prefix + server::printable_text(text) + '\n';
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace

std::string printable(std::string_view text) {
  return server::printable_text(text);
}

void set_quiet() {
  quiet = true;
}

int report(const Error& error) {
  print_line("isosplat: ",
             error.message.empty() ? status_cause(error.status) : std::string_view(error.message));
  return error.status == Status::invalid_argument ? kUsage : kFailure;
}

void note(std::string_view text) {
  if (!quiet) print_line("note: ", text);
}

std::string no_isosurface(const StoreInfo& info, double isovalue) {
  const float quantized_isovalue = info.mapping.quantized_isovalue(isovalue);
  if (quantized_isovalue >= static_cast<float>(info.range.min) &&
      quantized_isovalue < static_cast<float>(info.range.max)) {
    return {};
  }
  return fmt::format("no isosurface at {}: the volume's values are {} to {}", isovalue,
                     info.mapping.value(info.range.min), info.mapping.value(info.range.max));
}

std::string format_bytes(uint64_t bytes) {
  if (bytes < 1000) return fmt::format("{} bytes", bytes);
  auto value = static_cast<double>(bytes);
  const char* unit = "";
  for (const char* next : {"kB", "MB", "GB", "TB"}) {
    if (value < 999.5) break;
    value /= 1000;
    unit = next;
  }
  return fmt::format("{:.3g} {}", value, unit);
}

std::string format_seconds(double seconds) {
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<int64_t>(seconds + 0.5);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

std::string with_commas(uint64_t number) {
  std::string text = std::to_string(number);
  for (size_t position = text.size(); position > 3;) text.insert(position -= 3, 1, ',');
  return text;
}

ProgressLine::ProgressLine(std::string label)
    : label_(std::move(label)), terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  clear();
}

void ProgressLine::show(double fraction, std::string_view detail) {
  if (quiet) return;
  fraction = std::clamp(fraction, 0.0, 1.0);
  if (!terminal_) {
    const int tenth = static_cast<int>(fraction * 10);
    if (tenth == tenth_) return;
    tenth_ = tenth;
    fmt::print(stderr, "{}: {} %, {}\n", label_, 10 * tenth, detail);
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  winsize size{};
  const int columns =
      ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
  constexpr int kBar = 24;
  const int filled = static_cast<int>(std::lround(fraction * kBar));
  std::string bar;
  for (int i = 0; i < kBar; ++i) bar += i < filled ? "█" : "░";
  std::string rest = fmt::format(" {:3.0f} % {}", 100 * fraction, detail);
  const auto room = static_cast<size_t>(std::max(0, columns - kBar - 2));
  std::string label = label_ + " ";
  if (label.size() + rest.size() > room) rest.resize(room > label.size() ? room - label.size() : 0);
  fmt::print(stderr, "\r\033[K{}{}{}", label, bar, rest);
  std::fflush(stderr);
}

void ProgressLine::clear() {
  if (drawn_) {
    fmt::print(stderr, "\r\033[K");
    std::fflush(stderr);
  }
  drawn_ = false;
}

}  // namespace isosplat::cli
