// TLS: versions, ALPN, resumption, certificates that are read again, and clients that do not speak
// TLS.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sys/socket.h>
#include <unistd.h>

#include <functional>
#include <memory>

#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

template <class T, void (*kFree)(T*)>
struct Free {
  void operator()(T* object) const { kFree(object); }
};
template <class T, void (*kFree)(T*)>
using Owned = std::unique_ptr<T, Free<T, kFree>>;

/// Writes NAME.pem and NAME.key: a certificate for NAME, signed by itself.
void write_certificate(const std::filesystem::path& folder, const std::string& name) {
  const Owned<EVP_PKEY, EVP_PKEY_free> key(EVP_EC_gen("P-256"));
  const Owned<X509, X509_free> certificate(X509_new());
  X509_set_version(certificate.get(), 2);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate.get()), 1);
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -60);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), 24 * 3600);
  X509_set_pubkey(certificate.get(), key.get());
  X509_NAME* const subject = X509_get_subject_name(certificate.get());
  X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  X509_set_issuer_name(certificate.get(), subject);
  ASSERT_GT(X509_sign(certificate.get(), key.get(), EVP_sha256()), 0);
  FILE* file = std::fopen((folder / (name + ".pem")).c_str(), "w");
  ASSERT_EQ(PEM_write_X509(file, certificate.get()), 1);
  std::fclose(file);
  file = std::fopen((folder / (name + ".key")).c_str(), "w");
  ASSERT_EQ(PEM_write_PrivateKey(file, key.get(), nullptr, nullptr, 0, nullptr, nullptr), 1);
  std::fclose(file);
}

/// A client that checks no certificate. Null pointers and empty texts: the defaults.
struct TlsClient {
  struct Options {
    int least = TLS1_2_VERSION, most = 0;  ///< 0: the newest version
    std::string_view protocols = {};       ///< ALPN: each after its length
    SSL_SESSION* session = nullptr;
    const char* ciphers = nullptr;
    std::string_view before = {};  ///< bytes to send before the handshake
  };

  explicit TlsClient(uint16_t port) : TlsClient(port, Options{}) {}
  TlsClient(uint16_t port, const Options& options) : context(SSL_CTX_new(TLS_client_method())) {
    SSL_CTX_set_min_proto_version(context.get(), options.least);
    SSL_CTX_set_max_proto_version(context.get(), options.most);
    // The client admits old versions and ciphers, so that only the server can refuse them.
    SSL_CTX_set_cipher_list(context.get(), options.ciphers ? options.ciphers : "ALL:@SECLEVEL=0");
    ssl.reset(SSL_new(context.get()));
    if (!options.protocols.empty()) {
      SSL_set_alpn_protos(ssl.get(),
                          reinterpret_cast<const unsigned char*>(options.protocols.data()),
                          static_cast<unsigned>(options.protocols.size()));
    }
    if (options.session) SSL_set_session(ssl.get(), options.session);
    socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const timeval patience{20, 0};
    ::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) return;
    ::send(socket, options.before.data(), options.before.size(), MSG_NOSIGNAL);
    SSL_set_fd(ssl.get(), socket);
    is_open = SSL_connect(ssl.get()) == 1;
  }
  ~TlsClient() { ::close(socket); }
  TlsClient(const TlsClient&) = delete;
  TlsClient& operator=(const TlsClient&) = delete;

  /// The response to a request that closes the connection.
  std::string get(const std::string& target, const std::string& headers = {}) {
    const std::string request = "GET " + target + " HTTP/1.1\r\nHost: localhost\r\n" + headers +
                                "Connection: close\r\n\r\n";
    if (SSL_write(ssl.get(), request.data(), static_cast<int>(request.size())) <= 0) return "";
    std::string response;
    char piece[16384];
    int bytes = 0;
    while ((bytes = SSL_read(ssl.get(), piece, sizeof piece)) > 0) {
      response.append(piece, static_cast<size_t>(bytes));
    }
    was_closed_by_notice = SSL_get_error(ssl.get(), bytes) == SSL_ERROR_ZERO_RETURN;
    return response;
  }

  std::string name_of_server() const {
    const Owned<X509, X509_free> certificate(SSL_get1_peer_certificate(ssl.get()));
    char text[100] = {};
    X509_NAME_get_text_by_NID(X509_get_subject_name(certificate.get()), NID_commonName, text,
                              sizeof text);
    return text;
  }

  Owned<SSL_CTX, SSL_CTX_free> context;
  Owned<SSL, SSL_free> ssl;
  int socket = -1;
  bool is_open = false;
  bool was_closed_by_notice = false;
};

class Tls : public ServerTest {
 protected:
  Tls() {
    write_certificate(certificates.path(), "one");
    write_certificate(certificates.path(), "two");
    use("one");
    options.tls_certificate = certificates.path() / "server.pem";
    options.tls_key = certificates.path() / "server.key";
  }

  void use(const std::string& name) const {
    for (const char* end : {".pem", ".key"}) {
      std::filesystem::copy_file(certificates.path() / (name + end),
                                 certificates.path() / (std::string("server") + end),
                                 std::filesystem::copy_options::overwrite_existing);
    }
  }

  TemporaryFolder certificates;
};

TEST_F(Tls, ServesTheSameBytes) {
  start();
  EXPECT_TRUE(server->url().starts_with("https://localhost:")) << server->url();
  for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
    TlsClient client(port(), {.least = version, .most = version});
    ASSERT_TRUE(client.is_open) << version;
    const std::string response = client.get(content("file"));
    EXPECT_TRUE(response.starts_with("HTTP/1.1 200 OK\r\n"));
    EXPECT_EQ(response.substr(response.find("\r\n\r\n") + 4), text_of(alpha.file));
    EXPECT_TRUE(client.was_closed_by_notice)
        << "a client must distinguish the end from a lost connection";
  }
}

TEST_F(Tls, AHeaderOfTheProxyProtocolPrecedesTheHandshake) {
  options.trusted_proxies = {"127.0.0.1"};
  options.proxy_fields.client = ClientField::proxy_protocol;
  std::string logged;
  options.access_log = [&](std::string_view line) { logged = line; };
  start();
  TlsClient client(port(), {.before = "PROXY TCP4 192.0.2.7 10.0.0.1 56324 443\r\n"});
  ASSERT_TRUE(client.is_open);
  EXPECT_TRUE(client.get("/healthz").starts_with("HTTP/1.1 200"));
  server.reset();
  EXPECT_TRUE(logged.starts_with("192.0.2.7 GET /healthz")) << logged;
}

TEST_F(Tls, OldVersionsAndCiphersAreRefused) {
  start();
  for (const int version : {TLS1_VERSION, TLS1_1_VERSION}) {
    EXPECT_FALSE(TlsClient(port(), {.least = version, .most = version}).is_open) << version;
  }
  // Ciphers without forward secrecy, or without authenticated encryption.
  for (const char* cipher : {"AES128-GCM-SHA256", "ECDHE-ECDSA-AES128-SHA"}) {
    EXPECT_FALSE(TlsClient(port(), {.most = TLS1_2_VERSION, .ciphers = cipher}).is_open) << cipher;
  }
  EXPECT_TRUE(
      TlsClient(port(), {.most = TLS1_2_VERSION, .ciphers = "ECDHE-ECDSA-AES128-GCM-SHA256"})
          .is_open);
}

TEST_F(Tls, ChoosesHttp11) {
  start();
  TlsClient browser(port(), {.protocols = "\x02h2\x08http/1.1"});
  ASSERT_TRUE(browser.is_open);
  const unsigned char* name = nullptr;
  unsigned bytes = 0;
  SSL_get0_alpn_selected(browser.ssl.get(), &name, &bytes);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(name), bytes), "http/1.1");
  EXPECT_FALSE(TlsClient(port(), {.protocols = "\x02h2"}).is_open);
}

TEST_F(Tls, ResumesSessions) {
  start();
  for (const int version : {TLS1_2_VERSION, TLS1_3_VERSION}) {
    TlsClient first(port(), {.least = version, .most = version});
    EXPECT_FALSE(first.get("/healthz").empty());
    EXPECT_EQ(SSL_session_reused(first.ssl.get()), 0);
    const Owned<SSL_SESSION, SSL_SESSION_free> session(SSL_get1_session(first.ssl.get()));
    // The session would not be reused if the client had other options.
    TlsClient second(port(), {.least = version, .most = version, .session = session.get()});
    ASSERT_TRUE(second.is_open);
    EXPECT_EQ(SSL_session_reused(second.ssl.get()), 1) << version;
    EXPECT_TRUE(second.get("/healthz").starts_with("HTTP/1.1 200")) << version;
  }
}

TEST_F(Tls, ReadsCertificatesAgain) {
  start();
  TlsClient before(port());
  EXPECT_EQ(before.name_of_server(), "one");
  use("two");
  EXPECT_TRUE(server->reload());
  EXPECT_EQ(TlsClient(port()).name_of_server(), "two");
  EXPECT_TRUE(before.get("/healthz").starts_with("HTTP/1.1 200")) << "open connections go on";
  // If the key does not match the certificate, or a file is truncated, the previous files stay in
  // use.
  std::filesystem::copy_file(certificates.path() / "one.key", options.tls_key,
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_FALSE(server->reload());
  EXPECT_EQ(TlsClient(port()).name_of_server(), "two");
  std::filesystem::resize_file(options.tls_certificate, 100);
  EXPECT_FALSE(server->reload());
  EXPECT_TRUE(will_log("the old ones stay"));
  EXPECT_EQ(TlsClient(port()).name_of_server(), "two");
}

TEST_F(Tls, InvalidCertificateFilesAreRefused) {
  options.tls_key = certificates.path() / "two.key";
  const auto mismatched = Server::start(options);
  ASSERT_FALSE(mismatched);
  EXPECT_EQ(mismatched.error().status, Status::io_error);
  EXPECT_NE(mismatched.error().message.find("expected the private key"), std::string::npos);
  options.tls_key = certificates.path() / "none.key";
  EXPECT_EQ(Server::start(options).error().status, Status::io_error);
  options.tls_key.clear();
  EXPECT_EQ(Server::start(options).error().status, Status::io_error);
}

TEST_F(Tls, ConnectionsWithoutTlsAreClosed) {
  options.limits.request_time = std::chrono::milliseconds(700);
  start();
  Client plain(port());
  plain.send("GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(plain.read(1 << 16).find("HTTP/1.1 200"), std::string::npos);
  EXPECT_TRUE(plain.is_closed());
  Client silent(port());
  EXPECT_TRUE(silent.is_closed()) << "a handshake has request_time";
  EXPECT_TRUE(TlsClient(port()).get("/healthz").starts_with("HTTP/1.1 200"));
}

/// The first message of a client, for a test that sends it in parts.
std::string client_hello() {
  const Owned<SSL_CTX, SSL_CTX_free> context(SSL_CTX_new(TLS_client_method()));
  const Owned<SSL, SSL_free> ssl(SSL_new(context.get()));
  BIO* const sent = BIO_new(BIO_s_mem());
  SSL_set_bio(ssl.get(), BIO_new(BIO_s_mem()), sent);  // owns both
  SSL_connect(ssl.get());                              // returns, since no response has arrived
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(sent, &bytes);
  return {bytes, static_cast<size_t>(size)};
}

void reset(TlsClient& client) {
  const linger at_once{1, 0};
  ::setsockopt(client.socket, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
}

TEST_F(Tls, StalledHandshakesMakeRoom) {
  options.limits.connections = 8;
  options.limits.connections_per_address = 0;
  options.limits.request_time = std::chrono::hours(1);
  options.limits.patience = std::chrono::hours(1);
  start();
  const std::string hello = client_hello();
  std::vector<Client> stalled;
  for (int round = 0; round < 4; ++round) {
    for (int i = 0; i < 20; ++i) {
      // The first client sends nothing, the next one half of its first message, and the next one
      // all of it.
      stalled.emplace_back(port(), "127.0.0.3");
      stalled.back().send(hello.substr(0, hello.size() * static_cast<size_t>(i % 3) / 2));
    }
    EXPECT_TRUE(eventually([&] {
      TlsClient other(port());
      return other.is_open && other.get("/healthz").starts_with("HTTP/1.1 200");
    })) << round;
  }
  TlsClient last(port());
  EXPECT_EQ(last.get("/metrics").find("isosplat_connections_closed_total 0"), std::string::npos);
}

TEST_F(Tls, ResetsOfTheClientReleaseEverything) {
  const KnownStore large = make_store(3, {128, 128, 128}, 2'000'000);
  write_file(folder.path() / "large.isosplat", large.file);
  // Memory for two bodies, and three connections. The test fails if the server does not release
  // them.
  options.limits.bytes_in_flight = 1 << 20;
  options.limits.connections_per_address = 3;
  options.scan_interval = std::chrono::hours(1);
  start();
  const std::string hello = client_hello();
  ASSERT_GT(hello.size(), 100u);
  const std::string file = "/v1/volumes/large/" + large.content + "/file";
  const std::string request = "GET " + file + " HTTP/1.1\r\nHost: localhost\r\n\r\n";
  const auto is_served = [&] {
    return TlsClient(port()).get(content("file")).ends_with(text_of(alpha.file));
  };
  ASSERT_TRUE(is_served());
  ASSERT_TRUE(TlsClient(port()).get("/v1/volumes/large").starts_with("HTTP/1.1 200"));
  const size_t before = open_descriptors();
  const std::vector<std::pair<const char*, std::function<void()>>> stages = {
      {"before the handshake", [&] { Client(port()).reset(); }},
      {"within the first message",
       [&] {
         Client client(port());
         EXPECT_TRUE(client.send(hello.substr(0, hello.size() / 2)));
         client.reset();
       }},
      {"within the handshake",
       [&] {
         Client client(port());
         EXPECT_TRUE(client.send(hello));
         EXPECT_EQ(client.read(5).size(), 5u) << "the server's part has begun";
         client.reset();
       }},
      {"after the handshake",
       [&] {
         TlsClient client(port());
         EXPECT_TRUE(client.is_open);
         reset(client);
       }},
      {"within a request",
       [&] {
         TlsClient client(port());
         EXPECT_GT(SSL_write(client.ssl.get(), request.data(), 20), 0);
         reset(client);
       }},
      {"within a body", [&] {
         TlsClient client(port());
         EXPECT_GT(SSL_write(client.ssl.get(), request.data(), static_cast<int>(request.size())),
                   0);
         char byte = 0;
         EXPECT_EQ(SSL_read(client.ssl.get(), &byte, 1), 1);
         reset(client);
       }}};
  for (const auto& [stage, reset_there] : stages) {
    for (int i = 0; i < 3; ++i) {
      reset_there();
      ASSERT_TRUE(eventually([&] { return open_descriptors() <= before; })) << stage;
    }
    EXPECT_TRUE(eventually(is_served)) << stage;
  }
}

TEST_F(Tls, PlainRequestsAreRedirected) {
  options.http_port = 0;
  options.hsts_seconds = 86'400;
  options.allowed_hosts = {"volumes.example"};
  options.tokens = {"token-0123456789abcdef"};
  start();
  const uint16_t plain = server->http_port();
  ASSERT_NE(plain, 0);
  const auto location = [&](const std::string& request) {
    Client client(plain);
    client.send(request + "\r\n\r\n");
    const Answer answer = client.receive(request.starts_with("HEAD"));
    EXPECT_EQ(answer.status, 308) << request;
    EXPECT_EQ(answer.header("strict-transport-security"), "") << "not over plain HTTP";
    EXPECT_EQ(answer.header("set-cookie"), "");
    return answer.header("location");
  };
  const std::string port_text = ":" + std::to_string(port());
  EXPECT_EQ(location("GET /?volume=alpha&x=%22 HTTP/1.1\r\nHost: Volumes.Example:80"),
            "https://volumes.example" + port_text + "/?volume=alpha&x=%22");
  EXPECT_EQ(location("HEAD /v1/volumes HTTP/1.1\r\nHost: localhost"),
            "https://localhost" + port_text + "/v1/volumes");
  EXPECT_EQ(location("POST / HTTP/1.1\r\nHost: 127.0.0.1"), "https://127.0.0.1" + port_text + "/");
  EXPECT_EQ(location("GET http://localhost?a=b HTTP/1.1\r\nHost: evil.example"),
            "https://localhost" + port_text + "/?a=b");
  EXPECT_EQ(location("GET //evil.example/ HTTP/1.1\r\nHost: localhost"),
            "https://localhost" + port_text + "//evil.example/");
  EXPECT_EQ(location("GET /<\"\xc3\xbc HTTP/1.1\r\nHost: localhost"),
            "https://localhost" + port_text + "/%3C%22%C3%BC");
  // The server never redirects to a host that it does not know, and this port sends no data to
  // anyone.
  Client client(plain);
  client.send("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n");
  EXPECT_EQ(client.receive().status, 403);
  client.send(
      "GET /v1/volumes HTTP/1.1\r\nHost: localhost\r\n"
      "Authorization: Bearer token-0123456789abcdef\r\n\r\n");
  EXPECT_EQ(client.receive().status, 308);
  client.send("GET / HTTP/1.0\r\n\r\n");
  EXPECT_EQ(client.receive().status, 400);
  EXPECT_NE(
      TlsClient(port()).get("/healthz").find("\r\nStrict-Transport-Security: max-age=86400\r\n"),
      std::string::npos);
}

TEST_F(Tls, RedirectionsNameOneHostWhateverIsAllowed) {
  options.http_port = 0;
  options.https_port = 443;
  options.is_public = true;
  start();
  for (const auto& [host, expected] :
       std::initializer_list<std::pair<const char*, int>>{{"a.example", 308},
                                                          {"[::1]:80", 308},
                                                          {"a.example/x", 400},
                                                          {"a@b", 400},
                                                          {"a\\b", 400},
                                                          {"", 400},
                                                          {"a?b", 400},
                                                          {"a#b", 400}}) {
    Client client(server->http_port());
    client.send(std::string("GET / HTTP/1.1\r\nHost: ") + host + "\r\n\r\n");
    const Answer answer = client.receive();
    EXPECT_EQ(answer.status, expected) << host;
    if (expected == 308) {
      EXPECT_FALSE(answer.header("location").ends_with("443/")) << host;
    }
  }
}

TEST_F(Tls, RedirectionNeedsTls) {
  options.tls_certificate.clear();
  options.tls_key.clear();
  options.http_port = 0;
  EXPECT_EQ(Server::start(options).error().status, Status::invalid_argument);
  options.http_port.reset();
  options.hsts_seconds = 1;
  EXPECT_EQ(Server::start(options).error().status, Status::invalid_argument);
}

TEST_F(Tls, MetricsReportHandshakesAndCertificates) {
  start();
  Client(port()).send("GET / HTTP/1.1\r\n\r\n");
  EXPECT_TRUE(eventually([&] {
    return TlsClient(port()).get("/metrics").find("\nisosplat_tls_failures_total 1\n") !=
           std::string::npos;
  }));
  const std::string text = TlsClient(port()).get("/metrics");
  const size_t at = text.find("\nisosplat_tls_certificate_end_seconds ");
  ASSERT_NE(at, std::string::npos);
  // The certificates of these tests are valid for a day.
  const double days =
      (std::stod(text.substr(text.find(' ', at))) - static_cast<double>(std::time(nullptr))) /
      86400;
  EXPECT_NEAR(days, 1, 0.2);
  EXPECT_TRUE(will_log("the certificate ends in "));
}

TEST_F(Tls, CookiesAreForTlsOnly) {
  options.tokens = {"token-0123456789abcdef"};
  write_file(certificates.path() / "index.html", std::string_view("<title>I</title>"));
  options.web_root = certificates.path();
  start();
  const std::string moved = TlsClient(port()).get("/?token=token-0123456789abcdef");
  EXPECT_TRUE(moved.starts_with("HTTP/1.1 303 ")) << moved;
  EXPECT_NE(moved.find("; SameSite=Strict; Secure\r\n"), std::string::npos) << moved;
}

}  // namespace
}  // namespace isosplat::server::test
