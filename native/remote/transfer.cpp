#include "native/remote/transfer.h"

#include <curl/curl.h>
#include <isosplat/version.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <exception>

namespace isosplat::remote {
namespace {

constexpr std::array<std::string_view, 9> kHeaders = {"content-encoding",
                                                      "content-length",
                                                      "content-range",
                                                      "etag",
                                                      "last-modified",
                                                      "location",
                                                      "retry-after",
                                                      "x-amz-bucket-region",
                                                      "x-amz-meta-isosplat-upload"};
constexpr size_t kMaxHeaderBytes = 4096;
constexpr uint64_t kMaxErrorBytes = 16 * 1024;  // of the body of an error
constexpr long kMaxRedirects = 10;

/// The response that a handle receives, for the callbacks of libcurl.
struct Receiver {
  CURL* handle;
  const HttpRequest& request;
  HttpResponse response;
  std::exception_ptr failure;  ///< must not leave a callback, since libcurl is written in C
};

/// The largest body that is kept of the response.
uint64_t max_body_bytes(const Receiver& receiver) {
  long status = 0;
  curl_easy_getinfo(receiver.handle, CURLINFO_RESPONSE_CODE, &status);
  if (status < 200 || status >= 300) return kMaxErrorBytes;
  const HttpRequest& request = receiver.request;
  return status == 206 ? std::min(request.max_bytes, request.max_range_bytes) : request.max_bytes;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front()))) {
    text.remove_prefix(1);
  }
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) {
    text.remove_suffix(1);
  }
  return text;
}

void take_header(HttpResponse& response, std::string_view line) {
  if (line.starts_with("HTTP/")) response = {};  // the next response, after a redirect
  const size_t colon = line.find(':');
  if (colon == std::string_view::npos || line.size() > kMaxHeaderBytes) return;
  std::string name(line.substr(0, colon));
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (std::find(kHeaders.begin(), kHeaders.end(), name) != kHeaders.end()) {
    response.headers[name] = trimmed(line.substr(colon + 1));
  }
}

/// Keeps as much of the body as is asked for.
void take_body(Receiver& receiver, std::string_view bytes) {
  HttpResponse& response = receiver.response;
  const uint64_t limit = max_body_bytes(receiver);
  const auto kept =
      static_cast<size_t>(std::min<uint64_t>(bytes.size(), limit - response.body.size()));
  const auto* const first = reinterpret_cast<const std::byte*>(bytes.data());
  response.body.insert(response.body.end(), first, first + kept);
  response.is_cut = kept < bytes.size();
}

/// Calls f(). Returns `count`, or 0, which ends the transfer, if it throws or the body is cut.
template <class F>
size_t receive(Receiver& receiver, size_t count, F f) noexcept {
  try {
    f();
    return receiver.response.is_cut ? 0 : count;
  } catch (...) {
    receiver.failure = std::current_exception();
    return 0;
  }
}

size_t receive_header(char* bytes, size_t size, size_t count, void* data) {
  auto& receiver = *static_cast<Receiver*>(data);
  return receive(receiver, size * count, [&] {
    take_header(receiver.response, {bytes, size * count});
  });
}

size_t receive_body(char* bytes, size_t size, size_t count, void* data) {
  auto& receiver = *static_cast<Receiver*>(data);
  return receive(receiver, size * count, [&] { take_body(receiver, {bytes, size * count}); });
}

/// Whether a repetition may succeed after a fault.
bool may_pass(CURL* handle, CURLcode code) {
  long tunnel = 0;  // the status of a proxy that was asked for a tunnel
  curl_easy_getinfo(handle, CURLINFO_HTTP_CONNECTCODE, &tunnel);
  if (tunnel >= 400 && tunnel < 500) return false;
  switch (code) {
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_RESOLVE_PROXY:
    case CURLE_COULDNT_CONNECT:
    case CURLE_PARTIAL_FILE:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_GOT_NOTHING:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_SSL_CONNECT_ERROR:
    case CURLE_HTTP2:
    case CURLE_HTTP2_STREAM:
      return true;
    default:
      return false;
  }
}

struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
using HeaderList = std::unique_ptr<curl_slist, FreeList>;

void append(HeaderList& list, const std::string& line) {
  if (curl_slist* longer = curl_slist_append(list.get(), line.c_str())) {
    static_cast<void>(list.release());
    list.reset(longer);
  }
}

HeaderList header_list(const HttpRequest& request) {
  HeaderList list;
  for (const std::string& line : request.headers) append(list, line);
  if (request.signature && !request.signature->session_token.empty()) {
    append(list, "x-amz-security-token: " + request.signature->session_token);
  }
  return list;
}

void set_signature(CURL* handle, const AwsSignature& signature) {
  const std::string scope = "aws:amz:" + signature.region + ":s3";
  curl_easy_setopt(handle, CURLOPT_AWS_SIGV4, scope.c_str());
  curl_easy_setopt(handle, CURLOPT_USERNAME, signature.access_key.c_str());
  curl_easy_setopt(handle, CURLOPT_PASSWORD, signature.secret_key.c_str());
}

void set_body(CURL* handle, const HttpRequest& request) {
  curl_easy_setopt(handle, CURLOPT_POSTFIELDSIZE_LARGE,
                   static_cast<curl_off_t>(request.body.size()));
  // A null pointer would make libcurl read the body from standard input.
  const auto* const bytes = reinterpret_cast<const char*>(request.body.data());
  curl_easy_setopt(handle, CURLOPT_POSTFIELDS, request.body.empty() ? "" : bytes);
  curl_easy_setopt(handle, CURLOPT_CUSTOMREQUEST, request.method.c_str());
}

void set_up(CURL* handle, const HttpRequest& request, unsigned stall_s) {
  curl_easy_setopt(handle, CURLOPT_URL, request.url.c_str());
  curl_easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(handle, CURLOPT_USERAGENT, "isosplat/" ISOSPLAT_VERSION);
  curl_easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(handle, CURLOPT_REDIR_PROTOCOLS_STR,
                   request.url.starts_with("https:") ? "https" : "http,https");
  curl_easy_setopt(handle, CURLOPT_FOLLOWLOCATION, request.signature ? 0L : 1L);
  curl_easy_setopt(handle, CURLOPT_MAXREDIRS, kMaxRedirects);
  curl_easy_setopt(handle, CURLOPT_CONNECTTIMEOUT, static_cast<long>(stall_s));
  curl_easy_setopt(handle, CURLOPT_LOW_SPEED_LIMIT, 1000L);
  curl_easy_setopt(handle, CURLOPT_LOW_SPEED_TIME,
                   static_cast<long>(std::max(stall_s, request.stall_s)));
  if (const char* certificates = std::getenv("SSL_CERT_FILE")) {
    curl_easy_setopt(handle, CURLOPT_CAINFO, certificates);
    // Debian's libcurl also trusts the certificates of a folder unless this is unset.
    curl_easy_setopt(handle, CURLOPT_CAPATH, nullptr);
  }
  if (request.method == "HEAD") {
    curl_easy_setopt(handle, CURLOPT_NOBODY, 1L);
  } else if (request.method != "GET") {
    set_body(handle, request);
  }
  if (request.signature) set_signature(handle, *request.signature);
}

std::string describe(CURLcode code, const char* detail, unsigned stall_s) {
  if (code == CURLE_OPERATION_TIMEDOUT) {
    return "no data for " + std::to_string(stall_s) + " s";
  }
  return *detail ? detail : curl_easy_strerror(code);
}

}  // namespace

Transfers::~Transfers() {
  for (void* handle : idle_) curl_easy_cleanup(handle);
}

void* Transfers::take_handle() {
  static const CURLcode initialized = curl_global_init(CURL_GLOBAL_DEFAULT);
  if (initialized != CURLE_OK) return nullptr;
  const std::scoped_lock lock(mutex_);
  if (idle_.empty()) return curl_easy_init();
  void* const handle = idle_.back();
  idle_.pop_back();
  return handle;
}

tl::expected<HttpResponse, TransferFault> Transfers::send(const HttpRequest& request) {
  CURL* const handle = take_handle();
  if (!handle) return tl::unexpected(TransferFault{"libcurl cannot be started", false});
  Receiver receiver{handle, request, {}, nullptr};
  std::array<char, CURL_ERROR_SIZE> detail{};
  const HeaderList headers = header_list(request);
  set_up(handle, request, stall_s_);
  curl_easy_setopt(handle, CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(handle, CURLOPT_ERRORBUFFER, detail.data());
  curl_easy_setopt(handle, CURLOPT_HEADERFUNCTION, receive_header);
  curl_easy_setopt(handle, CURLOPT_HEADERDATA, &receiver);
  curl_easy_setopt(handle, CURLOPT_WRITEFUNCTION, receive_body);
  curl_easy_setopt(handle, CURLOPT_WRITEDATA, &receiver);
  const CURLcode code = curl_easy_perform(handle);
  long status = 0;
  curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
  receiver.response.status = static_cast<int>(status);
  const bool passes = may_pass(handle, code);
  curl_easy_reset(handle);  // keeps connections, and forgets the credentials
  {
    const std::scoped_lock lock(mutex_);
    idle_.push_back(handle);
  }
  if (receiver.failure) std::rethrow_exception(receiver.failure);
  if (code == CURLE_OK || (code == CURLE_WRITE_ERROR && receiver.response.is_cut)) {
    return std::move(receiver.response);
  }
  return tl::unexpected(
      TransferFault{describe(code, detail.data(), std::max(stall_s_, request.stall_s)), passes});
}

}  // namespace isosplat::remote
