#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace isosplat::server::test {

/// A response as it was received from the socket.
struct Answer {
  int status = 0;                                   ///< 0: no response
  std::multimap<std::string, std::string> headers;  ///< names in lower case
  std::string body;
  bool complete = false;  ///< the body has the announced number of bytes

  /// The field's value; "" if it is missing, "(repeated)" if there are several.
  std::string header(const std::string& name) const;
};

/// A client that sends bytes unchanged, so that tests can send invalid requests.
class Client {
 public:
  /// `from`: the client's address, such as "127.0.0.2"; null: the system chooses it.
  explicit Client(uint16_t port, const char* from = nullptr);
  ~Client();
  Client(Client&& other) noexcept;
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// Returns false if the server has closed the connection.
  bool send(std::string_view bytes);

  /// The next response. `to_header`: it is the response to HEAD, so no body follows.
  Answer receive(bool to_header = false);

  /// send() of a request with these further header lines ("Name: value\r\n"), then receive().
  Answer request(std::string_view method, std::string_view target, std::string_view headers = {});

  /// Whether the server closes the connection within the time. Bytes that arrive before are
  /// dropped.
  bool is_closed_within(std::chrono::milliseconds time);

  /// Whether the server closes the connection. Waits as long as a slow machine may need.
  bool is_closed() { return is_closed_within(std::chrono::minutes(2)); }

  /// Reads the next `bytes` bytes; fewer at the end of the connection.
  std::string read(size_t bytes);

  /// Ends the connection with a reset, as the system does when a program is killed before it has
  /// read all responses.
  void reset();

  /// Sends nothing more, but continues to read.
  void end_sending();

  /// Limits the bytes that the kernel buffers for this client. A small limit makes a slow reader.
  void set_receive_buffer(int bytes);

 private:
  bool fill();
  int socket_ = -1;
  std::string received_;
};

/// Sends one request on a separate connection.
Answer get(uint16_t port, std::string_view target, std::string_view headers = {});

}  // namespace isosplat::server::test
