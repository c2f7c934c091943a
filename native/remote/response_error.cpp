#include <fmt/format.h>

#include "native/remote/http_client.h"

namespace isosplat::remote {
namespace {

constexpr size_t kMaxShown = 200;  // characters of a server's text

/// What a user can do about an error code of S3, or about a status.
std::string remedy(const HttpResponse& response, const RemoteTarget& target,
                   std::string_view code) {
  if (code == "ExpiredToken" || code == "InvalidToken" || code == "TokenRefreshRequired") {
    return "the session's credentials are no longer valid: get new ones, for example with aws sso "
           "login";
  }
  if (code == "RequestTimeTooSkewed") return "set this machine's clock";
  if (code == "InvalidAccessKeyId" || code == "SignatureDoesNotMatch") {
    return "check AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or the profile";
  }
  const std::string region = response.header("x-amz-bucket-region");
  const bool is_other = target.signature ? region != target.signature->region
                                         : response.status == 301 || response.status == 307;
  if (!region.empty() && is_other) {
    return "the bucket is in another region: set AWS_REGION to " + region;
  }
  if (code == "NoSuchBucket") return "check the name of the bucket, and --endpoint";
  switch (response.status) {
    case 401:
    case 403:
      return "check that you may access it: its permissions, and your credentials";
    case 404:
    case 410:
      return "check the address";
    case 301:
    case 302:
    case 307:
    case 308:
      return "check AWS_REGION and --endpoint";
    default:
      return response.status >= 500 || response.status == 429 ? "try again later"
                                                              : "check the address";
  }
}

}  // namespace

std::string element_text(std::string_view xml, const std::string& name, size_t max_bytes) {
  const std::string open = "<" + name + ">", close = "</" + name + ">";
  const size_t begin = xml.find(open);
  if (begin == std::string_view::npos) return {};
  const std::string_view rest = xml.substr(begin + open.size());
  const size_t end = rest.find(close);
  if (end == std::string_view::npos) return {};
  return std::string(rest.substr(0, std::min(end, max_bytes)));
}

Error response_error(const HttpResponse& response, const RemoteTarget& target,
                     const std::string& action) {
  const std::string code = element_text(response.text(), "Code", kMaxShown);
  const std::string message = element_text(response.text(), "Message", kMaxShown);
  std::string found = fmt::format("status {}", response.status);
  if (!code.empty()) found += fmt::format(" ({}{}{})", code, message.empty() ? "" : ": ", message);
  return {Status::io_error,
          fmt::format("{}: {} failed: expected success, found {}: {}", target.name, action, found,
                      remedy(response, target, code))};
}

}  // namespace isosplat::remote
