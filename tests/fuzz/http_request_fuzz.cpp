// Bytes from a client: finding the end of the header, parsing the request and its target, writing
// the body of the answer, and the line of the access log.
//
// The input is a request as it comes over a socket, with cookies, tokens and signed links. If it
// begins with "~", it is the last part of a target, after the content id of a volume, which the
// fuzzer could not guess. If it begins with "#", it is a token file.

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "server/access_log.h"
#include "server/request_parser.h"
#include "server/router.h"
#include "tests/server/test_store.h"

namespace {

using namespace isosplat;

void require(bool condition) {
  if (!condition) std::abort();
}

/// A store and its router, created once.
struct Site {
  Site() {
    test::write_file(folder.path() / "a.isosplat", store.file);
    catalog.scan();
    auto rules = std::make_shared<AccessRules>();
    require(rules->add_token("0123456789abcdef0123456789abcdef").has_value());
    require(rules->set_link_key("fedcba9876543210fedcba9876543210").has_value());
    closed.set_access(rules);
    closed.set_cookies({"isosplat-1", false});
    closed.set_policy(OriginPolicy(AllowedHosts{.any = true}, CrossOrigin{.any = true}));
    open.set_policy(OriginPolicy(AllowedHosts{.any = true}, CrossOrigin{.any = true}));
  }
  test::TemporaryFolder folder;
  test::KnownStore store = test::make_store(1, {70, 40, 40}, 200);
  Catalog catalog{{folder.path()}, [](std::string_view) {}};
  mutable StorePool stores{{.stores = 1, .directory_bytes = 1 << 20}, [](std::string_view) {}};
  RouterLimits limits{.query_bytes = 5000, .query_chunks = 50, .target_bytes = 8192};
  Router router{catalog, stores, limits};  // for this machine
  Router open{catalog, stores, limits};    // for everyone
  Router closed{catalog, stores, limits};  // for those with a token or link, which no input has
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

/// Nothing of the volume may come without a token.
void refuse(const Site& site, const Request& request) {
  const Response response = site.closed.respond(request);
  require(!response.stream && response.headers.find("Set-Cookie") == std::string::npos);
  require(response.headers.find(site.store.content) == std::string::npos);
  require(response.text.find(site.store.content) == std::string::npos);
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
    refuse(site, request);
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
    refuse(site, parser.request());
  }
  log(parser);
  return 0;
}
