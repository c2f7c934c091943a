#include "server/http/request_parser.h"

#include <fmt/format.h>

#include <boost/asio/buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/parser.hpp>
#include <iterator>
#include <limits>
#include <string>

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;

Response closing(int status, std::string_view name, std::string_view message) {
  Response response = error_response(status, name, message);
  response.close = true;
  return response;
}

Response bad_request(std::string_view message) {
  return closing(400, "bad_request", message);
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

/// Whether the request line ends in a version "HTTP/d.d".
bool names_a_version(std::string_view header) {
  constexpr std::string_view kForm = "HTTP/d.d";
  const std::string_view line = header.substr(0, header.find("\r\n"));
  if (line.size() < kForm.size()) return false;
  const std::string_view version = line.substr(line.size() - kForm.size());
  for (size_t i = 0; i < kForm.size(); ++i) {
    const char c = version[i];
    if (kForm[i] == 'd' ? c < '0' || c > '9' : c != kForm[i]) return false;
  }
  return true;
}

}  // namespace

HeaderScan scan_header(std::string_view received, size_t scanned, size_t max_bytes,
                       size_t max_target_bytes) {
  using State = HeaderScan::State;
  if (received.empty()) return {};
  // All other bytes are not HTTP, such as a TLS greeting, which has no end of a header.
  const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  if (!is_letter(received.front())) {
    return {State::refused, 0, bad_request("expected an HTTP/1.1 request")};
  }
  for (size_t at = scanned; (at = received.find('\n', at)) != std::string_view::npos; ++at) {
    if (received[at - 1] != '\r') {
      return {State::refused, 0, bad_request("expected lines that end in CR LF")};
    }
    if (at >= 3 && received.substr(at - 3, 4) == "\r\n\r\n") {
      if (at + 1 > max_bytes) break;
      return {State::complete, at + 1, std::nullopt};
    }
  }
  if (received.size() <= max_bytes) return {};
  if (received.substr(0, max_bytes).find('\n') == std::string_view::npos) {
    return {State::refused, 0,
            closing(414, "target_too_long",
                    fmt::format("expected a target of at most {} bytes", max_target_bytes))};
  }
  return {State::refused, 0,
          closing(431, "header_too_large",
                  fmt::format("expected a header of at most {} bytes", max_bytes))};
}

struct RequestParser::State {
  http::request_parser<http::empty_body> parser;
};

RequestParser::RequestParser() : state_(std::make_unique<State>()) {
  state_->parser.header_limit(std::numeric_limits<uint32_t>::max());
  // No limit here: bodies are refused below. (Boost 1.74 refuses Content-Length: 0 if there is a
  // limit.)
  state_->parser.body_limit(std::numeric_limits<uint64_t>::max());
}

RequestParser::~RequestParser() = default;

std::optional<Response> RequestParser::parse(std::string_view header) {
  // Beast joins the lines of a folded field. Other programs treat the second line as a separate
  // field, or refuse it, as RFC 9112 (5.2) requires.
  for (const std::string_view fold : {"\r\n ", "\r\n\t"}) {
    if (header.find(fold) != std::string_view::npos) {
      return bad_request("expected each header field on one line");
    }
  }
  auto& parser = state_->parser;
  boost::system::error_code error;
  parser.put(asio::buffer(header.data(), header.size()), error);
  if (error == http::error::bad_version && names_a_version(header)) {
    return closing(505, "version_not_supported", "expected HTTP/1.1");
  }
  if (error) return bad_request("expected an HTTP/1.1 request: " + error.message());
  if (!parser.is_header_done()) return bad_request("expected an HTTP/1.1 request");

  const auto& message = parser.get();
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
    return bad_request(fmt::format("Host: expected exactly one, found {}", hosts));
  }
  return std::nullopt;
}

Request RequestParser::request() const {
  const auto& message = state_->parser.get();
  Request request;
  request.method = method_of(message.method());
  request.target = message.target();
  const auto host = message.find(http::field::host);
  request.has_host = host != message.end();
  if (request.has_host) request.host = host->value();
  request.origin = message[http::field::origin];
  request.sec_fetch_site = message["Sec-Fetch-Site"];
  request.authorization = message[http::field::authorization];
  request.cookie = message[http::field::cookie];
  request.accept_encoding = message[http::field::accept_encoding];
  request.if_match = message[http::field::if_match];
  request.if_none_match = message[http::field::if_none_match];
  request.if_range = message[http::field::if_range];
  request.range = message[http::field::range];
  request.request_id = message["X-Request-Id"];
  for (const std::string_view name : {"Forwarded", "X-Forwarded-For", "X-Real-IP", "Via"}) {
    request.is_forwarded = request.is_forwarded || message.find(name) != message.end();
  }
  return request;
}

std::string_view RequestParser::single(std::string_view name) const {
  const auto [first, last] = state_->parser.get().equal_range({name.data(), name.size()});
  if (first == last || std::next(first) != last) return {};
  return {first->value().data(), first->value().size()};
}

std::string RequestParser::list(std::string_view name) const {
  std::string joined;
  const auto fields = state_->parser.get().equal_range({name.data(), name.size()});
  for (auto field = fields.first; field != fields.second; ++field) {
    if (field != fields.first) joined += ", ";
    joined += std::string_view(field->value().data(), field->value().size());
  }
  return joined;
}

std::string_view RequestParser::method_text() const {
  return state_->parser.get().method_string();
}

bool RequestParser::keep_alive() const {
  // Do not use the function of the message: it takes the first of several Connection fields for
  // all.
  return state_->parser.is_header_done() && state_->parser.keep_alive();
}

bool RequestParser::is_http_1_0() const {
  return state_->parser.get().version() < 11;
}

}  // namespace isosplat::server
