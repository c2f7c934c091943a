#include "server/net/http_get.h"

#include <fmt/format.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <exception>
#include <optional>
#include <utility>

#include "server/net/asio.h"

namespace isosplat::server {
namespace {

namespace asio = boost::asio;
namespace http = boost::beast::http;
using boost::system::error_code;
using tcp = asio::ip::tcp;
using Resolver = asio::ip::basic_resolver<tcp, Executor>;

struct Address {
  bool has_tls = false;
  std::string host, port, path, authority;
};

std::optional<Address> parse_address(std::string_view url) {
  Address address;
  address.has_tls = url.starts_with("https://");
  if (!address.has_tls && !url.starts_with("http://")) return std::nullopt;
  url.remove_prefix(address.has_tls ? 8 : 7);
  const size_t end = std::min(url.find('/'), url.size());
  address.authority = url.substr(0, end);
  address.path = end == url.size() ? "/" : url.substr(end);
  const auto is_visible = [](char c) { return c > 0x20 && c < 0x7f && c != '@' && c != '#'; };
  if (!std::all_of(url.begin(), url.end(), is_visible)) return std::nullopt;
  std::string_view host = address.authority;
  address.port = address.has_tls ? "443" : "80";
  const size_t colon = host.rfind(':');
  if (colon != host.npos && host.find(']', colon) == host.npos) {
    address.port = host.substr(colon + 1);
    host = host.substr(0, colon);
  }
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  address.host = host;
  if (host.empty() || address.port.empty()) return std::nullopt;
  return address;
}

template <class Stream>
Awaitable<error_code> exchange(Stream& stream, const Address& address, size_t max_bytes,
                               HttpAnswer& answer) {
  http::request<http::empty_body> request(http::verb::get, address.path, 11);
  request.set(http::field::host, address.authority);
  request.set(http::field::connection, "close");
  error_code error;
  co_await http::async_write(stream, request, await(error));
  if (error) co_return error;
  boost::beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(max_bytes);
  co_await http::async_read(stream, buffer, parser, await(error));
  answer.status = static_cast<int>(parser.get().result_int());
  answer.body = std::move(parser.get().body());
  co_return error;
}

Awaitable<error_code> get(const Address& address, const HttpGetOptions& options,
                          asio::io_context& context, HttpAnswer& answer) {
  Resolver resolver(context.get_executor());
  error_code error;
  const auto found = co_await resolver.async_resolve(address.host, address.port, await(error));
  if (error) co_return error;
  Socket socket(context.get_executor());
  co_await asio::async_connect(socket, found, await(error));
  if (error) co_return error;
  if (!address.has_tls) co_return co_await exchange(socket, address, options.max_bytes, answer);
  asio::ssl::context tls(asio::ssl::context::tls_client);
  asio::ssl::stream<Socket&> stream(socket, tls);
  SSL_set_tlsext_host_name(stream.native_handle(), address.host.c_str());
  if (options.verifies_certificate) {
    tls.set_default_verify_paths(error);
    if (!error) stream.set_verify_mode(asio::ssl::verify_peer, error);
    if (!error) {
      stream.set_verify_callback(asio::ssl::host_name_verification(address.host), error);
    }
    if (error) co_return error;
  }
  co_await stream.async_handshake(asio::ssl::stream_base::client, await(error));
  if (error) co_return error;
  co_return co_await exchange(stream, address, options.max_bytes, answer);
}

}  // namespace

Result<HttpAnswer> http_get(std::string_view url, const HttpGetOptions& options) {
  const std::optional<Address> address = parse_address(url);
  if (!address) {
    return fail(Status::invalid_argument,
                fmt::format("expected an address http://HOST/PATH or https://…, found '{}'", url));
  }
  asio::io_context context(1);
  HttpAnswer answer;
  std::optional<error_code> result;
  asio::co_spawn(context, get(*address, options, context, answer),
                 [&](const std::exception_ptr& thrown, error_code error) {
                   result = thrown ? make_error_code(boost::system::errc::io_error) : error;
                 });
  context.run_for(options.timeout);
  if (!result) return fail(Status::io_error, fmt::format("{}: no answer in time", url));
  if (*result) return fail(Status::io_error, fmt::format("{}: {}", url, result->message()));
  return answer;
}

}  // namespace isosplat::server
