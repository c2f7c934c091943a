#include "server/connection.h"

#include <array>
#include <boost/asio/as_tuple.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <ctime>
#include <optional>
#include <span>
#include <utility>

#include "server/streams.h"

namespace isosplat {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using boost::system::error_code;
using tcp = asio::ip::tcp;

using Stream = beast::basic_stream<tcp, Executor, beast::unlimited_rate_policy>;
using Parser = http::request_parser<http::empty_body>;
using Clock = std::chrono::steady_clock;

template <class T>
using Awaitable = asio::awaitable<T, Executor>;

constexpr auto kAwait = asio::as_tuple(asio::use_awaitable_t<Executor>{});

/// The Date field's value (RFC 9110, 5.6.7), made anew once a second on each thread.
std::string_view http_date() {
  thread_local std::time_t made = -1;
  thread_local std::array<char, 40> text{};
  const std::time_t now = std::time(nullptr);
  if (now != made) {
    std::tm parts{};
    ::gmtime_r(&now, &parts);
    // Names by hand: strftime would take those of the process's locale.
    constexpr const char* kDays[] = {"Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"};
    constexpr const char* kMonths[] = {"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                       "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
    std::snprintf(text.data(), text.size(), "%s, %02d %s %04d %02d:%02d:%02d GMT",
                  kDays[parts.tm_wday % 7], parts.tm_mday % 100, kMonths[parts.tm_mon % 12],
                  (parts.tm_year + 1900) % 10000, parts.tm_hour % 100, parts.tm_min % 100,
                  parts.tm_sec % 100);
    made = now;
  }
  return text.data();
}

std::string header_block(const Response& response, bool close, bool http_1_0) {
  std::string text;
  text.reserve(512 + response.headers.size());
  text += "HTTP/1.1 ";
  text += std::to_string(response.status);
  text += ' ';
  text += reason_phrase(response.status);
  text += "\r\nDate: ";
  text += http_date();
  text += "\r\nServer: isosplat\r\n";
  if (response.status != 204 && response.status != 304) {
    text += "Content-Length: ";
    text += std::to_string(response.body_size());
    text += "\r\n";
  }
  if (close) {
    text += "Connection: close\r\n";
  } else if (http_1_0) {
    text += "Connection: keep-alive\r\n";
  }
  text += response.headers;
  text += "\r\n";
  return text;
}

Response bad_request(std::string_view message) {
  Response response = error_response(400, "bad_request", message);
  response.close = true;
  return response;
}

Method method_of(http::verb verb) {
  switch (verb) {
    case http::verb::get:
      return Method::get;
    case http::verb::head:
      return Method::head;
    case http::verb::options:
      return Method::options;
    default:
      return Method::other;
  }
}

/// What makes a request unsafe to answer on a connection that goes on: two readers could see its
/// end in two places. Beast takes all of these.
std::optional<Response> unsafe_request(const http::request<http::empty_body>& message) {
  if (message.find(http::field::transfer_encoding) != message.end()) {
    return bad_request("Transfer-Encoding: expected a request without a body");
  }
  const auto lengths = message.equal_range(http::field::content_length);
  for (auto length = lengths.first; length != lengths.second; ++length) {
    if (length->value() != "0" || length != lengths.first) {
      return bad_request("Content-Length: expected a request without a body");
    }
  }
  const size_t hosts = message.count(http::field::host);
  if (hosts > 1 || (hosts == 0 && message.version() >= 11)) {
    return bad_request("Host: expected exactly one, found " + std::to_string(hosts));
  }
  return std::nullopt;
}

/// The answer to bytes that are not a request; nothing where the client is not worth one.
std::optional<Response> parse_error_response(const error_code& error, const Parser& parser,
                                             const ServerLimits& limits) {
  Response response;
  if (error == http::error::header_limit || error == http::error::buffer_overflow) {
    if (parser.get().target().empty()) {
      response = error_response(
          414, "target_too_long",
          "expected a target of at most " + std::to_string(limits.target_bytes) + " bytes");
    } else {
      response = error_response(
          431, "header_too_large",
          "expected a header of at most " + std::to_string(limits.header_bytes) + " bytes");
    }
  } else if (error == http::error::bad_version) {
    response = error_response(505, "version_not_supported", "expected HTTP/1.1");
  } else if (error.category() == http::make_error_code(http::error::bad_method).category() &&
             error != http::error::end_of_stream && error != http::error::partial_message) {
    response = bad_request("expected an HTTP/1.1 request: " + error.message());
  } else {
    return std::nullopt;
  }
  response.close = true;
  return response;
}

std::string log_escaped(std::string_view text) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string result;
  for (const char c : text) {
    if (c > 0x20 && c < 0x7f && c != '"' && c != '\\') {
      result += c;
    } else {
      result += "\\x";
      result += kDigits[static_cast<unsigned char>(c) >> 4];
      result += kDigits[c & 15];
    }
  }
  return result;
}

}  // namespace

struct Connection::State {
  Stream stream;
  std::string address;
  const ConnectionShared& shared;
  beast::flat_buffer buffer;
  bool is_idle = false;

  /// False: the connection is of no more use.
  Awaitable<bool> write(std::span<const std::byte> first, std::span<const std::byte> second);
  Awaitable<bool> write_response(Response& response, bool close, bool http_1_0, bool head);
  Awaitable<bool> wait_for_request();
  Awaitable<bool> answer_next();
  Awaitable<void> linger();
  void write_access_log(std::string_view method, std::string_view target, const Response& response,
                        Clock::time_point begin);
};

Connection::Connection(Socket socket, std::string address, const ConnectionShared& shared)
    : state_(new State{Stream(std::move(socket)), std::move(address), shared,
                       // Room for a header of the largest size and what follows it.
                       beast::flat_buffer(shared.limits.header_bytes + 4096)}) {}

Connection::~Connection() = default;

void Connection::stop() {
  if (state_->is_idle) abort();
}

void Connection::abort() {
  state_->stream.close();
}

Awaitable<void> Connection::run(std::unique_ptr<Response> refusal) {
  State& state = *state_;
  error_code ignored;
  state.stream.socket().set_option(tcp::no_delay(true), ignored);
  if (refusal) {
    if (co_await state.write_response(*refusal, true, false, false)) co_await state.linger();
  } else {
    // Two statements: g++ 12 awaits the right side of "co_await a && co_await b" in any case.
    for (bool goes_on = true; goes_on;) {
      goes_on = co_await state.wait_for_request();
      if (goes_on) goes_on = co_await state.answer_next();
    }
  }
  state.stream.close();
}

/// The first byte of a request may take as long as idle_time, the rest of it not.
Awaitable<bool> Connection::State::wait_for_request() {
  constexpr size_t kReadBytes = 4096;
  if (buffer.size() > 0) co_return true;
  if (shared.stopping) co_return false;
  buffer.shrink_to_fit();
  stream.expires_after(shared.limits.idle_time);
  is_idle = true;
  const auto [error, bytes] = co_await stream.async_read_some(buffer.prepare(kReadBytes), kAwait);
  is_idle = false;
  if (error) co_return false;
  buffer.commit(bytes);
  co_return true;
}

Awaitable<bool> Connection::State::answer_next() {
  Parser parser;
  parser.header_limit(static_cast<uint32_t>(shared.limits.header_bytes));
  parser.body_limit(boost::none);
  stream.expires_after(shared.limits.request_time);
  const auto [error, bytes] = co_await http::async_read_header(stream, buffer, parser, kAwait);
  const Clock::time_point begin = Clock::now();
  const http::request<http::empty_body>& message = parser.get();

  Response response;
  if (error) {
    std::optional<Response> answer = parse_error_response(error, parser, shared.limits);
    if (!answer) co_return false;
    response = std::move(*answer);
  } else if (std::optional<Response> answer = unsafe_request(message)) {
    response = std::move(*answer);
  } else {
    Request request;
    request.method = method_of(message.method());
    request.target = message.target();
    request.accept_encoding = message[http::field::accept_encoding];
    request.if_match = message[http::field::if_match];
    request.if_none_match = message[http::field::if_none_match];
    request.if_range = message[http::field::if_range];
    request.range = message[http::field::range];
    response = shared.router.answer(request);
  }
  if (!response.fault.empty() && shared.log) shared.log(response.fault);

  const bool close = error || response.close || !message.keep_alive() || shared.stopping;
  const bool is_head = !error && message.method() == http::verb::head;
  const bool sent = co_await write_response(response, close, message.version() < 11, is_head);
  write_access_log(message.method_string(), message.target(), response, begin);
  if (!sent) co_return false;
  if (close) co_await linger();
  co_return !close;
}

/// Both spans, in slices: each must be taken within write_time.
Awaitable<bool> Connection::State::write(std::span<const std::byte> first,
                                         std::span<const std::byte> second) {
  do {
    const std::span<const std::byte> slice = second.first(std::min(second.size(), kPieceBytes));
    second = second.subspan(slice.size());
    const std::array<asio::const_buffer, 2> buffers = {
        asio::const_buffer(first.data(), first.size()),
        asio::const_buffer(slice.data(), slice.size())};
    first = {};
    stream.expires_after(shared.limits.write_time);
    const auto [error, bytes] = co_await asio::async_write(stream, buffers, kAwait);
    if (error) co_return false;
  } while (!second.empty());
  co_return true;
}

Awaitable<bool> Connection::State::write_response(Response& response, bool close, bool http_1_0,
                                                  bool head) {
  const std::string header = header_block(response, close, http_1_0);
  std::span<const std::byte> waiting = std::as_bytes(std::span(header));
  if (head || response.body_size() == 0) co_return co_await write(waiting, {});
  if (!response.stream) {
    const bool is_text = response.bytes.data() == nullptr;
    co_return co_await write(waiting,
                             is_text ? std::as_bytes(std::span(response.text)) : response.bytes);
  }
  std::vector<std::byte> piece;
  for (auto step = BodyStream::Step::more; step == BodyStream::Step::more;) {
    piece.clear();
    Error error;
    step = response.stream->next(piece, error);
    if (!co_await write(waiting, piece)) co_return false;
    waiting = {};
    if (step == BodyStream::Step::broken) {
      if (shared.log) shared.log(error.message);
      co_return false;
    }
  }
  co_return true;
}

/// Reads on for a moment after the last answer: closing with unread bytes would make the kernel
/// reset the connection, and the client could lose the answer.
Awaitable<void> Connection::State::linger() {
  constexpr auto kLongest = std::chrono::seconds(2);
  constexpr size_t kMostBytes = 256 * 1024;
  error_code failed;
  stream.socket().shutdown(tcp::socket::shutdown_send, failed);
  if (failed) co_return;
  std::array<std::byte, 4096> unread;
  stream.expires_after(std::min<Clock::duration>(kLongest, shared.limits.write_time));
  for (size_t total = 0; total < kMostBytes;) {
    const auto [error, bytes] = co_await stream.async_read_some(asio::buffer(unread), kAwait);
    if (error) co_return;
    total += bytes;
  }
}

void Connection::State::write_access_log(std::string_view method, std::string_view target,
                                         const Response& response, Clock::time_point begin) {
  if (!shared.access_log) return;
  const auto milliseconds =
      std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - begin).count();
  shared.access_log(address + " " + log_escaped(method) + " " + log_escaped(target) + " " +
                    std::to_string(response.status) + " " + std::to_string(response.body_size()) +
                    " " + std::to_string(milliseconds) + "ms");
}

}  // namespace isosplat
