#include "tests/server/http_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace isosplat::server::test {
namespace {

constexpr int kTimeoutMs = 120'000;

std::string lower(std::string text) {
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

}  // namespace

std::string Answer::header(const std::string& name) const {
  const auto [first, last] = headers.equal_range(name);
  if (first == last) return "";
  return std::next(first) == last ? first->second : "(repeated)";
}

Client::Client(uint16_t port, const char* from) {
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  if (from) {
    address.sin_family = AF_INET;
    ::inet_pton(AF_INET, from, &address.sin_addr);
    ::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address);
  }
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    ::close(socket_);
    throw std::runtime_error("cannot connect");
  }
}

Client::~Client() {
  if (socket_ >= 0) ::close(socket_);
}

Client::Client(Client&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), received_(std::move(other.received_)) {}

void Client::reset() {
  const linger at_once{1, 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  ::close(std::exchange(socket_, -1));
}

void Client::end_sending() {
  ::shutdown(socket_, SHUT_WR);
}

void Client::set_receive_buffer(int bytes) {
  ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
}

bool Client::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<size_t>(sent));
  }
  return true;
}

bool Client::fill() {
  pollfd ready{socket_, POLLIN, 0};
  if (::poll(&ready, 1, kTimeoutMs) <= 0) return false;
  char piece[65536];
  const ssize_t got = ::recv(socket_, piece, sizeof piece, 0);
  if (got <= 0) return false;
  received_.append(piece, static_cast<size_t>(got));
  return true;
}

std::string Client::read(size_t bytes) {
  while (received_.size() < bytes && fill()) {
  }
  std::string result = received_.substr(0, bytes);
  received_.erase(0, result.size());
  return result;
}

Answer Client::receive(bool to_header) {
  Answer answer;
  size_t end = 0;
  while ((end = received_.find("\r\n\r\n")) == std::string::npos) {
    if (!fill()) return answer;
  }
  std::string head = received_.substr(0, end + 2);
  received_.erase(0, end + 4);
  if (!head.starts_with("HTTP/1.1 ")) throw std::runtime_error("not an answer: " + head);
  answer.status = std::stoi(head.substr(9, 3));
  size_t line = head.find("\r\n") + 2;
  while (line < head.size()) {
    const size_t next = head.find("\r\n", line);
    const size_t colon = head.find(": ", line);
    if (colon >= next) throw std::runtime_error("not a header field: " + head.substr(line));
    answer.headers.emplace(lower(head.substr(line, colon - line)),
                           head.substr(colon + 2, next - colon - 2));
    line = next + 2;
  }
  const std::string length = answer.header("content-length");
  const bool has_body =
      !to_header && answer.status != 204 && answer.status != 304 && !length.empty();
  const size_t expected = has_body ? std::stoull(length) : 0;
  answer.body = read(expected);
  answer.complete = answer.body.size() == expected;
  return answer;
}

Answer Client::request(std::string_view method, std::string_view target, std::string_view headers) {
  std::string text(method);
  text += ' ';
  text += target;
  text += " HTTP/1.1\r\nHost: localhost\r\n";
  text += headers;
  text += "\r\n";
  send(text);
  return receive(method == "HEAD");
}

bool Client::is_closed_within(std::chrono::milliseconds time) {
  const auto deadline = std::chrono::steady_clock::now() + time;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(
        deadline - std::chrono::steady_clock::now());
    if (left.count() <= 0) return false;
    pollfd ready{socket_, POLLIN, 0};
    if (::poll(&ready, 1, static_cast<int>(left.count())) <= 0) return false;
    char piece[4096];
    if (::recv(socket_, piece, sizeof piece, 0) <= 0) return true;
  }
}

Answer get(uint16_t port, std::string_view target, std::string_view headers) {
  return Client(port).request("GET", target, headers);
}

}  // namespace isosplat::server::test
