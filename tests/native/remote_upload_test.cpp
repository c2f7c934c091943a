// What remains of an upload whose file cannot be read.
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "native/remote/bucket_upload.h"

namespace isosplat::remote {
namespace {

/// A service that accepts every upload, one request per connection.
class Service {
 public:
  Service() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    ::bind(listener_, reinterpret_cast<sockaddr*>(&address), size);
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    ::listen(listener_, 16);
    url = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + "/bucket/key";
    thread_ = std::thread([this] {
      for (int peer = ::accept(listener_, nullptr, nullptr); peer >= 0;
           peer = ::accept(listener_, nullptr, nullptr)) {
        answer(peer);
        ::close(peer);
      }
    });
  }
  ~Service() { stop(); }

  /// Afterwards, `methods` may be read.
  void stop() {
    if (!thread_.joinable()) return;
    ::shutdown(listener_, SHUT_RDWR);
    thread_.join();
    ::close(listener_);
  }

  std::string url;
  std::vector<std::string> methods;  ///< of all requests

 private:
  static void send(int peer, const std::string& text) {
    ::send(peer, text.data(), text.size(), MSG_NOSIGNAL);
  }

  void answer(int peer) {
    std::string request;
    std::array<char, 65536> piece;
    const auto receive = [&] {
      const ssize_t count = ::recv(peer, piece.data(), piece.size(), 0);
      if (count > 0) request.append(piece.data(), static_cast<size_t>(count));
      return count > 0;
    };
    while (request.find("\r\n\r\n") == std::string::npos) {
      if (!receive()) return;
    }
    const size_t begin = request.find("\r\n\r\n") + 4;
    const size_t length = request.find("Content-Length: ");
    const size_t bytes = length < begin ? std::stoul(request.substr(length + 16)) : 0;
    if (request.find("Expect: 100-continue") < begin) send(peer, "HTTP/1.1 100 Continue\r\n\r\n");
    while (request.size() < begin + bytes) {
      if (!receive()) return;
    }
    methods.push_back(request.substr(0, request.find(' ')));
    const std::string body = methods.back() == "POST" ? "<UploadId>id</UploadId>" : "";
    send(peer,
         "HTTP/1.1 200 OK\r\nConnection: close\r\nETag: \"a\"\r\n"
         "Content-Length: " +
             std::to_string(body.size()) + "\r\n\r\n" + body);
  }

  const int listener_ = ::socket(AF_INET, SOCK_STREAM, 0);
  std::thread thread_;
};

/// Its second part needs more memory than there is.
class UnreadableFile final : public RandomAccessFile {
 public:
  const std::string& name() const override { return name_; }
  Result<FileIdentity> identity(NoWait*) const override { return FileIdentity{}; }
  Result<void> read(uint64_t offset, std::span<std::byte>, NoWait*) const override {
    if (offset > 0) throw std::bad_alloc();
    return {};
  }

 private:
  const std::string name_ = "file";
};

TEST(RemoteUpload, IsAbortedWithAnErrorIfMemoryIsRefused) {
  Service service;
  HttpClient client;
  const auto signature =
      std::make_shared<const AwsSignature>(AwsSignature{"us-east-1", "key", "secret", ""});
  UploadOptions options;
  options.part_bytes = uint64_t{5} << 20;
  const auto sent = upload(client, {service.url, "s3://bucket/key", signature}, UnreadableFile(),
                           3 * options.part_bytes, options);
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().status, Status::io_error);
  EXPECT_NE(sent.error().message.find("out of memory"), std::string::npos);
  EXPECT_EQ(sent.error().message.find("remain in the bucket"), std::string::npos);
  service.stop();
  ASSERT_FALSE(service.methods.empty());
  EXPECT_EQ(service.methods.front(), "POST");
  EXPECT_EQ(service.methods.back(), "DELETE");
}

}  // namespace
}  // namespace isosplat::remote
