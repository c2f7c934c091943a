#include "native/remote/http_client.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <random>
#include <thread>

namespace isosplat::remote {
namespace {

constexpr std::chrono::milliseconds kLongestWait{30'000};

bool may_pass(const HttpResponse& response) {
  switch (response.status) {
    case 408:
    case 429:
    case 500:
    case 502:
    case 503:
    case 504:
      return true;
    case 400: {
      const std::string code = element_text(response.text(), "Code", 64);
      return code == "RequestTimeout" || code == "XAmzContentSHA256Mismatch";
    }
    default:
      return false;
  }
}

/// 0 to 1; differs between programs, so that many of them do not repeat at the same time.
double chance() {
  thread_local std::minstd_rand generator{std::random_device{}()};
  return std::uniform_real_distribution<double>(0, 1)(generator);
}

}  // namespace

std::chrono::milliseconds HttpClient::wait_before(unsigned attempt,
                                                  const HttpResponse* response) const {
  const double backoff = static_cast<double>(options_.first_wait.count()) *
                         static_cast<double>(1u << std::min(attempt - 1, 10u)) * (1 + chance() / 4);
  auto wait = std::chrono::milliseconds(static_cast<int64_t>(backoff));
  if (response) {
    const std::string text = response->header("retry-after");
    uint32_t seconds = 0;  // the other form, a date, is ignored
    std::from_chars(text.data(), text.data() + text.size(), seconds);
    wait = std::max(wait, std::chrono::milliseconds(uint64_t{seconds} * 1000));
  }
  return std::min(wait, kLongestWait);
}

Result<HttpResponse> HttpClient::send(const HttpRequest& request, const std::string& name) {
  for (unsigned attempt = 1;; ++attempt) {
    auto response = transfers_.send(request);
    const bool is_last = attempt >= std::max(options_.attempts, request.attempts);
    if (response && (is_last || !may_pass(*response))) return std::move(*response);
    if (!response && (is_last || !response.error().may_pass)) {
      return fail(Status::io_error,
                  fmt::format("{}: expected a response, found after {} attempt{}: {}: check the "
                              "address and the network, and try again",
                              name, attempt, attempt == 1 ? "" : "s", response.error().message));
    }
    std::this_thread::sleep_for(wait_before(attempt, response ? &*response : nullptr));
  }
}

}  // namespace isosplat::remote
