#include "server/access_options.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>

namespace isosplat::server {
namespace {

/// The contents of a small file, such as a list of tokens.
Result<std::string> read_text(const std::filesystem::path& path) {
  constexpr size_t kMaxBytes = 1 << 20;
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxBytes, '\0');
  file.read(text.data(), kMaxBytes);
  if (file.bad() || !file.eof()) {
    return fail(Status::io_error,
                fmt::format("{}: expected a file of less than 1 MiB: {}", path.string(),
                            file.eof() ? "it cannot be read" : std::strerror(errno)));
  }
  text.resize(static_cast<size_t>(file.gcount()));
  return text;
}

}  // namespace

AllowedHosts allowed_hosts(const ServerOptions& options, bool is_local) {
  AllowedHosts hosts;
  hosts.any = options.is_public;
  hosts.any_address = !is_local;
  const bool is_v6 = options.host.find(':') != std::string::npos;
  hosts.names.push_back(host_of(is_v6 ? fmt::format("[{}]", options.host) : options.host));
  for (const std::string& name : options.allowed_hosts) {
    if (name == "*") hosts.any = true;
    hosts.names.push_back(host_of(name));
  }
  char machine[256] = {};
  if (!is_local && ::gethostname(machine, sizeof machine - 1) == 0) {
    hosts.names.push_back(host_of(machine));
  }
  std::erase(hosts.names, "");  // malformed: no request's host is equal to it
  return hosts;
}

bool is_address(std::string_view keys) {
  return keys.starts_with("https://") || keys.starts_with("http://");
}

Result<std::shared_ptr<const AccessRules>> read_access(const ServerOptions& options,
                                                       std::string_view fetched_keys) {
  auto rules = std::make_shared<AccessRules>();
  for (const std::string& token : options.tokens) {
    if (Result<void> added = rules->add_token(token, std::string(kServerToken)); !added)
      return tl::unexpected(added.error());
  }
  const auto from_file = [](const std::filesystem::path& path, const auto& add) -> Result<void> {
    if (path.empty()) return {};
    const Result<std::string> text = read_text(path);
    if (!text) return tl::unexpected(text.error());
    Result<void> added = add(*text);
    if (added) return {};
    return fail(added.error().status, path.string() + ": " + added.error().message);
  };
  Result<void> read =
      from_file(options.token_file, [&](std::string_view text) { return rules->add_lines(text); });
  if (read && !options.link_key.empty()) read = rules->set_link_key(options.link_key);
  if (read) {
    read = from_file(options.link_key_file,
                     [&](std::string_view text) { return rules->set_link_key(text); });
  }
  if (read) {
    read = from_file(options.revoked_links_file,
                     [&](std::string_view text) { return rules->add_revoked_links(text); });
  }
  if (read && !options.jwt_keys.empty()) {
    const auto set = [&](std::string_view text) -> Result<void> {
      auto verifier = JwtVerifier::create(text, options.jwt);
      if (!verifier) return tl::unexpected(verifier.error());
      rules->set_jwt_verifier(std::move(*verifier));
      return {};
    };
    if (!is_address(options.jwt_keys)) {
      read = from_file(options.jwt_keys, set);
    } else if (!fetched_keys.empty()) {
      read = set(fetched_keys);
    } else {
      rules->close();  // until the keys have been fetched
    }
  }
  if (!read) return tl::unexpected(read.error());
  const bool has_identities = !options.jwt_keys.empty() || !options.proxy_fields.user.empty();
  if (has_identities && !rules->has_identity_rules()) {
    return fail(Status::invalid_argument,
                "identities: expected lines \"user:NAME PATTERN…\" or \"group:NAME PATTERN…\" in "
                "the token file, found none: nobody would be admitted");
  }
  return rules;
}

Result<OriginPolicy> origin_policy(const ServerOptions& options, bool is_local) {
  if (!is_local && !options.cross_origin && !options.is_public) {
    return fail(
        Status::invalid_argument,
        fmt::format("host {}: other machines can reach this address: choose which web pages of "
                    "other origins may read the volumes: --cors none, --cors https://a.example, "
                    "--cors '*', or --public (any page, by any host name)",
                    options.host));
  }
  CrossOrigin cross_origin = options.cross_origin.value_or(CrossOrigin{});
  if (options.is_public) cross_origin.any = true;
  return OriginPolicy(allowed_hosts(options, is_local), std::move(cross_origin));
}

std::vector<std::string> secret_file_warnings(const ServerOptions& options) {
  std::vector<std::string> warnings;
  for (const std::filesystem::path& path :
       {options.token_file, options.link_key_file, options.tls_key}) {
    struct stat status {};
    if (path.empty() || ::stat(path.c_str(), &status) != 0) continue;
    const bool can_read = status.st_mode & S_IROTH, can_write = status.st_mode & S_IWOTH;
    if (!can_read && !can_write) continue;
    warnings.push_back(fmt::format("warning: {}: all users of this machine can {} it: chmod o= {}",
                                   path.string(), can_write ? "change" : "read", path.string()));
  }
  return warnings;
}

std::string exposure_warning(const ServerOptions& options, uint16_t port, bool has_access_rules,
                             bool has_tls) {
  if (!has_access_rules) {
    return fmt::format(
        "warning: everyone who reaches {} port {} can read every volume: there is no access "
        "control (--token-file){}",
        options.host, port, has_tls ? "" : ", and no encryption (--tls-cert)");
  }
  return fmt::format(
      "warning: connections to {} port {} are not encrypted (--tls-cert): everyone on the way can "
      "read tokens, links and volumes",
      options.host, port);
}

}  // namespace isosplat::server
