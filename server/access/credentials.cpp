#include "server/access/credentials.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/beast/core/string.hpp>
#include <utility>
#include <vector>

namespace isosplat::server {
namespace {

/// The middle part of the name of a link's cookie. CookieOptions::name comes before it, and the
/// name of the volume or scene after it.
std::string_view link_cookie(ServedKind kind) {
  return kind == ServedKind::volume ? "-link-" : "-scene-";
}

/// Removes and returns the text before `separator`; all of it if there is none.
std::string_view take(std::string_view& text, char separator) {
  const std::string_view part = text.substr(0, text.find(separator));
  text.remove_prefix(std::min(part.size() + 1, text.size()));
  return part;
}

/// The value of a parameter that occurs exactly once; else empty.
std::string_view parameter(const Target& target, std::string_view key) {
  std::string_view value;
  size_t count = 0;
  for (const auto& [name, text] : target.query) {
    if (name != key) continue;
    value = text;
    ++count;
  }
  return count == 1 ? value : std::string_view();
}

/// The kind of a target below /v1/volumes or /v1/scenes.
std::optional<ServedKind> kind_of(const Target& target) {
  if (target.segments.size() < 3 || target.segments[0] != "v1") return std::nullopt;
  if (target.segments[1] == "volumes") return ServedKind::volume;
  if (target.segments[1] == "scenes") return ServedKind::scene;
  return std::nullopt;
}

/// The signed link in a query; its signature is empty if there is none. If the page's query names a
/// volume and a scene, the page shows the volume.
Credentials::Link link_of(const Target& target) {
  Credentials::Link link;
  if (const auto kind = kind_of(target)) {
    link.kind = *kind;
    link.name = target.segments[2];
  } else {
    const std::string_view scene = parameter(target, "scene");
    link.name = parameter(target, "volume");
    if (link.name.empty() && !scene.empty()) {
      link.kind = ServedKind::scene;
      link.name = scene;
    }
  }
  link.expires = parameter(target, kExpiresParameter);
  link.signature = parameter(target, kSignatureParameter);
  return link;
}

void add_cookies(std::string_view field, std::string_view cookie, Credentials& credentials) {
  while (!field.empty()) {
    std::string_view value = take(field, ';');
    value.remove_prefix(std::min(value.find_first_not_of(" \t"), value.size()));
    std::string_view name = take(value, '=');
    if (name == cookie) {
      if (credentials.tokens.size() < kMaxCredentials) credentials.tokens.push_back(value);
      continue;
    }
    if (!name.starts_with(cookie)) continue;
    name.remove_prefix(cookie.size());
    for (const ServedKind kind : {ServedKind::volume, ServedKind::scene}) {
      const std::string_view mark = link_cookie(kind);
      if (!name.starts_with(mark) || credentials.links.size() >= kMaxCredentials) continue;
      const std::string_view expires = take(value, '.');
      credentials.links.push_back({kind, name.substr(mark.size()), expires, value});
      break;
    }
  }
}

/// Text for a query: all characters except letters, digits and "-._~,:" are escaped.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if ((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
        std::string_view("-._~,:").find(c) != std::string_view::npos) {
      result += c;
    } else {
      result += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return result;
}

std::string cookie_field(std::string_view name, std::string_view value,
                         const CookieOptions& options) {
  // Strict: browsers do not send it with requests that other sites cause.
  return fmt::format("{}={}; Path=/; HttpOnly; SameSite=Strict{}", name, value,
                     options.is_secure ? "; Secure" : "");
}

}  // namespace

Credentials credentials_of(const Request& request, const Target& target, std::string_view cookie) {
  Credentials credentials;
  std::string_view authorization = request.authorization;
  constexpr std::string_view kScheme = "Bearer ";
  if (boost::beast::iequals(authorization.substr(0, kScheme.size()), kScheme)) {
    authorization.remove_prefix(kScheme.size());
    authorization.remove_prefix(
        std::min(authorization.find_first_not_of(' '), authorization.size()));
    credentials.tokens.push_back(authorization);
  }
  const Credentials::Link link = link_of(target);
  if (!link.signature.empty()) credentials.links.push_back(link);
  add_cookies(request.cookie, cookie, credentials);
  credentials.identity.user = request.user;
  for (std::string_view groups = request.groups; !groups.empty();) {
    std::string_view group = take(groups, ',');
    group.remove_prefix(std::min(group.find_first_not_of(" \t"), group.size()));
    group = group.substr(0, group.find_last_not_of(" \t") + 1);
    if (!group.empty()) credentials.identity.groups.emplace_back(group);
  }
  return credentials;
}

std::optional<Response> take_link(Target& target, const std::shared_ptr<const AccessRules>& rules,
                                  uint64_t now) {
  if (!rules || !kind_of(target) || !target.parameter(kSignatureParameter)) {
    return std::nullopt;
  }
  const Credentials::Link link = link_of(target);
  if (!AccessRules::grant(rules, {.tokens = {}, .links = {link}}, now).is_known()) {
    return unauthorized_response();
  }
  std::erase_if(target.query, [](const auto& parameter) {
    return parameter.first == kSignatureParameter || parameter.first == kExpiresParameter;
  });
  return std::nullopt;
}

std::optional<Response> exchange_token(const Target& target,
                                       const std::shared_ptr<const AccessRules>& rules,
                                       const CookieOptions& options, uint64_t now) {
  if (!rules || rules->is_open()) return std::nullopt;
  bool has_token = false;
  std::string_view token;  // the first valid one
  for (const auto& [name, value] : target.query) {
    if (name != kTokenParameter || value.empty()) continue;
    has_token = true;
    if (token.empty() &&
        AccessRules::grant(rules, {.tokens = {value}, .links = {}}, now).has_token()) {
      token = value;
    }
  }
  if (!has_token) return std::nullopt;
  if (token.empty()) return unauthorized_response();
  // A reference without a path keeps the path of the request, "./" its folder.
  std::string location = "?";
  for (const auto& [key, value] : target.query) {
    if (key == kTokenParameter) continue;
    if (location.size() > 1) location += '&';
    location += escaped(key);
    if (!value.empty()) location += '=' + escaped(value);
  }
  if (location.size() == 1) location = "./";
  Response response;
  response.status = 303;
  response.set("Location", location);
  response.set("Set-Cookie", cookie_field(options.name, token, options));
  response.set("Cache-Control", "no-store");
  response.set("Referrer-Policy", "no-referrer");
  return response;
}

void set_link_cookie(const Target& target, const std::shared_ptr<const AccessRules>& rules,
                     const CookieOptions& options, uint64_t now, Response& response) {
  const Credentials::Link link = link_of(target);
  if (link.signature.empty() || !rules || rules->is_open()) return;
  if (!AccessRules::grant(rules, {.tokens = {}, .links = {link}}, now).is_known()) return;
  // The signature is valid, so this server has written name, time and signature.
  response.set("Set-Cookie",
               cookie_field(fmt::format("{}{}{}", options.name, link_cookie(link.kind), link.name),
                            fmt::format("{}.{}", link.expires, link.signature), options));
}

Response unauthorized_response() {
  Response response = error_response(
      401, "unauthorized",
      "expected a token or link that is valid: open the whole address that the server printed, or "
      "the link that its operator sent; programs send Authorization: Bearer TOKEN");
  response.set("WWW-Authenticate", "Bearer realm=\"isosplat\"");
  return response;
}

std::string without_secrets(std::string_view target) {
  const size_t mark = std::min(target.find('?'), target.size());
  std::string result(target.substr(0, mark));
  std::string_view query = target.substr(mark);
  char separator = '?';
  while (!query.empty()) {
    query.remove_prefix(1);  // the separator
    const std::string_view item = query.substr(0, query.find('&'));
    query.remove_prefix(item.size());
    const std::string_view key = item.substr(0, item.find('='));
    result += separator;
    // An escaped key may be one of these, too.
    const bool is_secret = key == kTokenParameter || key == kSignatureParameter ||
                           key.find('%') != std::string_view::npos;
    result += is_secret ? key : item;
    if (is_secret) result += "=*";
    separator = '&';
  }
  return result;
}

}  // namespace isosplat::server
