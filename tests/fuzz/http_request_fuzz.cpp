// Bytes from a client. The server finds the end of the header, parses the request and its target,
// writes the body of the response, and writes the line of the access log.
//
// The input is a request as it arrives on a socket, with cookies, tokens and signed links. If it
// begins with "~", it is the last part of a target, after the content id of a volume, which the
// fuzzer could not guess. If it begins with "#", it is a token file.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/request_parser.h"
#include "server/log/access_log.h"
#include "server/routes/router.h"
#include "tests/server/test_store.h"

namespace {

using namespace isosplat;
using namespace isosplat::server;

void require(bool condition) {
  if (!condition) std::abort();
}

constexpr std::string_view kToken = "0123456789abcdef0123456789abcdef";  // for the volume a
constexpr std::string_view kLinkKey = "fedcba9876543210fedcba9876543210";
constexpr std::string_view kExpires = "4102444800";  // 2100-01-01

/// Two stores, a scene of both, and their routers, created once.
struct Site {
  Site() {
    test::write_file(folder.path() / "a.isosplat", store.file);
    test::write_file(folder.path() / "b.isosplat", other.file);
    const std::string scene =
        R"({"format":"isosplat-scene","version":1,"layers":[{"store":"a.isosplat"},{"store":"b.isosplat"}]})";
    const auto bytes = std::as_bytes(std::span(scene));
    test::write_file(folder.path() / "both.scene.json", {bytes.begin(), bytes.end()});
    catalog.scan();
    auto rules = std::make_shared<AccessRules>();
    require(rules->add_lines(std::string(kToken) + " a\n").has_value());
    require(rules->set_link_key(kLinkKey).has_value());
    closed.set_access(rules);
    closed.set_cookie_name("isosplat-1");
    closed.set_policy(OriginPolicy(AllowedHosts{.any = true}, CrossOrigin{.any = true}));
    open.set_policy(OriginPolicy(AllowedHosts{.any = true}, CrossOrigin{.any = true}));
    require_credentials_work();
  }

  /// Fails if the credentials of the seeds are not accepted: the checks below would then test
  /// nothing.
  void require_credentials_work() const {
    const std::string bearer = "Bearer " + std::string(kToken);
    const std::string cookie = "isosplat-1=" + std::string(kToken);
    const std::string link_cookie = "isosplat-1-link-a=" + std::string(kExpires) + "." + signature;
    const std::string link = "?exp=" + std::string(kExpires) + "&sig=" + signature;
    const auto status = [&](const std::string& target, std::string_view authorization,
                            std::string_view its_cookie) {
      Request request;
      request.method = Method::get;
      request.target = target;
      request.authorization = authorization;
      request.cookie = its_cookie;
      return closed.respond(request).status;
    };
    for (const auto& [volume, expected] : {std::pair("a", 200), std::pair("b", 404)}) {
      const std::string target = std::string("/v1/volumes/") + volume;
      require(status(target, bearer, {}) == expected);
      require(status(target, {}, cookie) == expected);
      require(status(target, {}, link_cookie) == expected);
      require(status(target, {}, {}) == 401);
    }
    require(status("/v1/volumes/a" + link, {}, {}) == 200);
    require(status("/v1/volumes/b" + link, {}, {}) == 401);
  }
  test::TemporaryFolder folder;
  test::KnownStore store = test::make_store(1, {70, 40, 40}, 200);
  test::KnownStore other = test::make_store(2, {5, 5, 5}, 10);
  std::string signature = sign_link(kLinkKey, ServedKind::volume, "a", kExpires);
  Catalog catalog{{folder.path()}, [](std::string_view) {}};
  mutable StorePool stores{{.stores = 1, .directory_bytes = 1 << 20}, [](std::string_view) {}};
  mutable ScenePool scenes{{}, ScenePool::OutsideLinks::followed, [](std::string_view) {}};
  RouterLimits limits{.query_bytes = 5000, .query_chunks = 50, .target_bytes = 8192};
  Router router{catalog, stores, scenes, limits};  // for this machine
  Router open{catalog, stores, scenes, limits};    // for everyone
  Router closed{catalog, stores, scenes, limits};  // a: for those with the token or the link
};

void answer(const Router& router, const Request& request) {
  Response response = router.respond(request);
  require(reason_phrase(response.status) != "Unknown");
  require(response.headers.empty() || response.headers.ends_with("\r\n"));
  require(response.headers.find("\r\n\r\n") == std::string::npos);
  require(response.headers.find('\0') == std::string::npos);
  if (!response.stream) return;
  std::vector<std::byte> body;
  Error error;
  BodyStream::Step step = BodyStream::Step::more;
  while (response.body_size() > 0 && step == BodyStream::Step::more) {
    step = response.stream->next(body, error, nullptr);
  }
  require(step != BodyStream::Step::broken);
  require(body.size() == response.body_size());
}

/// The text with its escapes decoded, as far as they are valid.
std::string decoded(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef0123456789ABCDEF";
  std::string result;
  while (!text.empty()) {
    const size_t high = text.size() > 2 ? kDigits.find(text[1]) : std::string_view::npos;
    const size_t low = text.size() > 2 ? kDigits.find(text[2]) : std::string_view::npos;
    const bool is_escape =
        text[0] == '%' && high != std::string_view::npos && low != std::string_view::npos;
    result += is_escape ? static_cast<char>(high % 16 * 16 + low % 16) : text[0];
    text.remove_prefix(is_escape ? 3 : 1);
  }
  return result;
}

/// Whether the request has the token or the signature anywhere.
bool has_secret(const Site& site, const Request& request) {
  for (const std::string_view secret : {kToken, std::string_view(site.signature)}) {
    if (request.authorization.find(secret) != std::string_view::npos ||
        request.cookie.find(secret) != std::string_view::npos ||
        decoded(request.target).find(secret) != std::string::npos) {
      return true;
    }
  }
  return false;
}

/// A redirection repeats the query, which may contain any text.
void require_nothing_of(const test::KnownStore& store, const Request& request,
                        const Response& response) {
  const size_t query = std::min(request.target.find('?'), request.target.size());
  if (decoded(request.target.substr(query)).find(store.content) != std::string::npos) return;
  require(response.headers.find(store.content) == std::string::npos);
  require(response.text.find(store.content) == std::string::npos);
}

/// A response may contain data of a volume only if the request has its token or link.
void check_access(const Site& site, const Request& request) {
  const Response response = site.closed.respond(request);
  require_nothing_of(site.other, request, response);
  if (has_secret(site, request)) {
    answer(site.closed, request);
  } else {
    require(!response.stream && response.headers.find("Set-Cookie") == std::string::npos);
    require_nothing_of(site.store, request, response);
  }
  require(without_secrets(request.target).size() <= 3 * request.target.size());
}

/// A line of the log has printable characters only, whatever the client sent.
void log(const RequestParser& parser) {
  const Request request = parser.request();
  const std::string id = request_id(request.request_id);
  require(is_request_id(id));
  AccessEntry entry;
  entry.id = id;
  entry.method = parser.method_text();
  entry.target = request.target;
  for (const LogFormat format : {LogFormat::plain, LogFormat::common, LogFormat::json}) {
    for (const char c : access_line(entry, format)) require(c >= 0x20 && c < 0x7f);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Site site;
  const std::string_view input(reinterpret_cast<const char*>(data), size);
  if (input.starts_with('~')) {
    const std::string target =
        "/v1/volumes/a/" + site.store.content + "/" + std::string(input.substr(1));
    Request request;
    request.method = Method::get;
    request.target = target;
    answer(site.open, request);
    check_access(site, request);
    return 0;
  }
  if (input.starts_with('#')) {
    AccessRules rules;
    if (rules.add_lines(input)) require(!rules.is_open());
    return 0;
  }

  // In two parts, as a socket may deliver it. The result must be the same.
  constexpr size_t kMaxBytes = 4096;
  const HeaderScan whole = scan_header(input, 0, kMaxBytes, 1024);
  const HeaderScan first = scan_header(input.substr(0, size / 2), 0, kMaxBytes, 1024);
  if (first.state == HeaderScan::State::partial) {
    const HeaderScan second = scan_header(input, size / 2, kMaxBytes, 1024);
    require(second.state == whole.state && second.bytes == whole.bytes);
  }
  if (whole.state != HeaderScan::State::complete) return 0;
  require(whole.bytes <= kMaxBytes && whole.bytes <= size);
  RequestParser parser;
  const std::optional<Response> refused = parser.parse(input.substr(0, whole.bytes));
  if (refused) {
    require(refused->close && refused->status >= 400);
  } else {
    answer(site.open, parser.request());
    answer(site.router, parser.request());
    check_access(site, parser.request());
  }
  log(parser);
  return 0;
}
