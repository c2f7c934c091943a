#include "server/access/access_rules.h"

#include <fmt/format.h>
#include <fnmatch.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <openssl/rand.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

#include "server/catalog/volume_names.h"
#include "server/http/target.h"

namespace isosplat::server {
namespace {

constexpr std::string_view kAnyone = "anyone", kUser = "user:", kGroup = "group:";

/// The beginning of patterns for scenes.
constexpr std::string_view kScene = "scene:";

std::string hexadecimal(std::span<const unsigned char> bytes) {
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

std::optional<std::array<unsigned char, 32>> sha256(std::string_view text) {
  std::array<unsigned char, 32> digest{};
  unsigned int bytes = 0;
  if (EVP_Digest(text.data(), text.size(), digest.data(), &bytes, EVP_sha256(), nullptr) != 1 ||
      bytes != digest.size()) {
    return std::nullopt;
  }
  return digest;
}

/// The characters of bearer tokens (RFC 6750, 2.1), all of which a cookie may hold.
bool is_token(std::string_view text) {
  return text.size() >= AccessRules::kMinTokenLength && std::ranges::all_of(text, [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  std::string_view("-._~+/=").find(c) != std::string_view::npos;
         });
}

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<std::string_view> words;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
    if (line.empty()) return words;
    words.push_back(line.substr(0, line.find_first_of(kBlanks)));
    line.remove_prefix(words.back().size());
  }
}

/// Whether `folder` is `outer` or below it.
bool is_within(std::string_view folder, std::string_view outer) {
  return folder.starts_with(outer) &&
         (folder.size() == outer.size() || outer == "/" || folder[outer.size()] == '/');
}

std::vector<std::string> segments_of(std::string_view text) {
  std::vector<std::string> segments;
  while (true) {
    segments.emplace_back(text.substr(0, text.find(kFolderSeparator)));
    if (segments.back().size() == text.size()) return segments;
    text.remove_prefix(segments.back().size() + 1);
  }
}

/// The name of a token: 1 to 64 letters, digits, "-", "_" and ".".
bool is_token_name(std::string_view text) {
  return !text.empty() && text.size() <= 64 && std::ranges::all_of(text, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_' || c == '.';
  });
}

}  // namespace

/// A volume or a scene that patterns are compared with.
class AccessRules::Subject {
 public:
  Subject(std::string_view name, const VolumeIdentity& identity)
      : name_(name), identity_(identity) {}

  bool matches(const NamePattern& pattern) {
    if (pattern.kind != identity_.kind && !pattern.is_for_both) return false;
    if (pattern.is_all) return true;
    if (pattern.segments.empty()) return pattern.text == name_;
    if (segments_.empty()) segments_ = segments_of(name_);
    const auto& unaltered = identity_.unaltered;
    const bool is_altered = unaltered.size() == segments_.size();
    const size_t compared = pattern.segments.size() - (pattern.goes_below ? 1 : 0);
    if (pattern.goes_below ? segments_.size() <= compared : segments_.size() != compared) {
      return false;
    }
    for (size_t i = 0; i < compared; ++i) {
      const std::string& expected = pattern.segments[i];
      // A segment that is a valid name is compared with the name. Others are compared with the
      // path.
      const bool is_equal =
          is_volume_name(expected)
              ? expected == segments_[i]
              : ::fnmatch(expected.c_str(), (is_altered ? unaltered : segments_)[i].c_str(),
                          FNM_NOESCAPE) == 0;
      if (!is_equal) return false;
    }
    return true;
  }

  bool is_within(std::string_view folder) const {
    return server::is_within(identity_.folder, folder);
  }

  bool is_store(std::string_view path) const {
    const std::string_view folder = identity_.folder, file = identity_.file;
    return path.size() == folder.size() + 1 + file.size() && path.starts_with(folder) &&
           path.ends_with(file) && path[folder.size()] == '/';
  }

 private:
  const std::string_view name_;
  const VolumeIdentity& identity_;
  std::vector<std::string> segments_;  ///< of the name, computed when needed
};

bool AccessRules::Patterns::admit(Subject& subject) const {
  return std::ranges::any_of(names,
                             [&](const NamePattern& name) { return subject.matches(name); }) ||
         std::ranges::any_of(
             folders, [&](const std::string& folder) { return subject.is_within(folder); }) ||
         std::ranges::any_of(stores,
                             [&](const std::string& store) { return subject.is_store(store); });
}

/// Errors (invalid_argument): a path that cannot be resolved.
Result<void> AccessRules::Patterns::add(std::string_view pattern) {
  if (pattern.find('/') == std::string_view::npos) {
    NamePattern name;
    if (pattern.starts_with(kScene)) {
      name.kind = ServedKind::scene;
      pattern.remove_prefix(kScene.size());
    }
    name.text = pattern;
    name.is_all = pattern == "*";
    name.goes_below = pattern.ends_with("~*");
    name.is_for_both = name.kind == ServedKind::volume && (name.is_all || name.goes_below);
    if (!is_volume_name(pattern)) name.segments = segments_of(pattern);
    names.push_back(std::move(name));
    return {};
  }
  // The store or the scene is the file of this name, even if it is a link.
  const std::filesystem::path given(pattern);
  const std::string file = given.filename().string();
  std::error_code error;
  const bool is_store =
      (is_listed(file, ServedKind::volume) || is_listed(file, ServedKind::scene)) &&
      !std::filesystem::is_directory(given, error);
  const auto absolute = std::filesystem::absolute(is_store ? given.parent_path() : given, error);
  std::string path = std::filesystem::weakly_canonical(absolute, error).string();
  if (error) return fail(Status::invalid_argument, fmt::format("{}: {}", pattern, error.message()));
  while (path.size() > 1 && path.ends_with('/')) path.pop_back();
  if (is_store) {
    stores.push_back((path == "/" ? path : path + '/') + given.filename().string());
  } else {
    folders.push_back(std::move(path));
  }
  return {};
}

AccessRules::AccessRules() {
  static std::atomic<uint64_t> last{0};
  id_ = ++last;
}

Result<void> AccessRules::add_lines(std::string_view text) {
  has_lines_ = true;
  for (size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty() || words.front().starts_with('#')) continue;
    const bool is_for_anyone = words.front() == kAnyone;
    const bool is_group = words.front().starts_with(kGroup);
    const std::string_view who = is_group ? words.front().substr(kGroup.size())
                                 : words.front().starts_with(kUser)
                                     ? words.front().substr(kUser.size())
                                     : std::string_view();
    if (!is_for_anyone && who.empty() && !is_token(words.front())) {
      return fail(Status::invalid_argument,
                  fmt::format("line {}: expected \"anyone\", user:NAME, group:NAME, or a token of "
                              "at least {} letters, digits and -._~+/=",
                              number, kMinTokenLength));
    }
    if (words.size() < 2) {
      return fail(Status::invalid_argument,
                  fmt::format("line {}: expected one or more names of volumes (\"*\": all) or "
                              "folders behind the token",
                              number));
    }
    constexpr std::string_view kName = "name=";
    std::span<const std::string_view> rest = std::span(words).subspan(1);
    std::string name = fmt::format("line-{}", number);
    if (rest.front().starts_with(kName)) {
      name = rest.front().substr(kName.size());
      rest = rest.subspan(1);
      if (is_for_anyone || !who.empty() || !is_token_name(name) || rest.empty()) {
        return fail(Status::invalid_argument,
                    fmt::format("line {}: expected name= behind a token, with 1 to 64 letters, "
                                "digits and -_. and then names of volumes or folders",
                                number));
      }
    }
    Patterns patterns;
    for (const std::string_view word : rest) {
      const Result<void> added = (is_for_anyone ? anyone_ : patterns).add(word);
      if (added) continue;
      return fail(Status::invalid_argument,
                  fmt::format("line {}: folder {}", number, added.error().message));
    }
    if (!who.empty()) {
      identity_rules_.push_back({is_group, std::string(who), std::move(patterns)});
      continue;
    }
    if (is_for_anyone) continue;
    const auto digest = sha256(words.front());
    if (!digest) return fail(Status::io_error, "tokens: SHA-256 is not available");
    rules_.push_back({*digest, std::move(name), std::move(patterns)});
  }
  return {};
}

Result<void> AccessRules::add_token(std::string_view token, std::string name) {
  if (!is_token(token)) {
    return fail(
        Status::invalid_argument,
        fmt::format("token: expected at least {} letters, digits and -._~+/=", kMinTokenLength));
  }
  const auto digest = sha256(token);
  if (!digest) return fail(Status::io_error, "tokens: SHA-256 is not available");
  Patterns all;
  if (Result<void> added = all.add("*"); !added) return added;
  rules_.push_back({*digest, std::move(name), std::move(all)});
  return {};
}

Result<void> AccessRules::set_link_key(std::string_view key) {
  while (key.ends_with('\n') || key.ends_with('\r')) key.remove_suffix(1);
  if (key.size() < kMinKeyLength) {
    return fail(Status::invalid_argument,
                fmt::format("key of links: expected at least {} bytes, found {}: make one with "
                            "openssl rand -hex 32",
                            kMinKeyLength, key.size()));
  }
  link_key_ = key;
  return {};
}

Result<void> AccessRules::add_revoked_links(std::string_view text) {
  for (size_t number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty() || words.front().starts_with('#')) continue;
    const std::string_view id = words.front().substr(0, kLinkIdLength);
    const bool is_id = id.size() == kLinkIdLength && std::ranges::all_of(id, [](char c) {
                         return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
                       });
    if (!is_id) {
      return fail(Status::invalid_argument,
                  fmt::format("line {}: expected the signature of a link (its sig=…), or its first "
                              "{} digits",
                              number, kLinkIdLength));
    }
    revoked_links_.emplace(id);
  }
  return {};
}

void AccessRules::admit_identity(const Identity& identity, Grant& grant) const {
  if (identity.user.empty()) return;
  grant.has_identity_ = true;
  const auto matches_name = [](const std::string& pattern, const std::string& name) {
    return ::fnmatch(pattern.c_str(), name.c_str(), FNM_NOESCAPE) == 0;
  };
  for (const IdentityRule& rule : identity_rules_) {
    const bool is_meant = rule.is_group
                              ? std::ranges::any_of(identity.groups,
                                                    [&](const std::string& group) {
                                                      return matches_name(rule.pattern, group);
                                                    })
                              : matches_name(rule.pattern, identity.user);
    if (is_meant) grant.patterns_.push_back(&rule.patterns);
  }
  if (grant.client_.empty()) grant.client_ = "user:" + identity.user;
}

Grant AccessRules::grant(std::shared_ptr<const AccessRules> rules, const Credentials& credentials,
                         uint64_t now) {
  Grant grant;
  if (!rules || rules->is_open()) return grant;
  rules->admit_identity(credentials.identity, grant);
  // Verifying a signature takes about as long as a request.
  constexpr size_t kMaxJwts = 2;
  size_t jwts = 0;
  for (const std::string_view token : credentials.tokens) {
    if (rules->jwt_verifier_ && JwtVerifier::is_jwt(token) && jwts++ < kMaxJwts) {
      if (const Result<Identity> identity = rules->jwt_verifier_->verify(token, now)) {
        rules->admit_identity(*identity, grant);
      }
    }
    const auto digest = sha256(token);
    if (!digest) continue;
    for (const Rule& rule : rules->rules_) {
      if (CRYPTO_memcmp(rule.token.data(), digest->data(), digest->size()) == 0) {
        grant.patterns_.push_back(&rule.patterns);
        if (grant.client_.empty()) grant.client_ = rule.name;
      }
    }
  }
  for (const Credentials::Link& link : credentials.links) {
    const std::optional<uint32_t> expires = parse_index(link.expires);
    if (rules->link_key_.empty() || !expires || *expires <= now) continue;
    const std::string expected = sign_link(rules->link_key_, link.kind, link.name, link.expires);
    if (!expected.empty() && expected.size() == link.signature.size() &&
        CRYPTO_memcmp(expected.data(), link.signature.data(), expected.size()) == 0 &&
        !rules->revoked_links_.contains(link.signature.substr(0, kLinkIdLength))) {
      grant.linked_.emplace_back(link.kind, link.name);
    }
  }
  grant.is_known_ = !grant.patterns_.empty() || !grant.linked_.empty() || grant.has_identity_;
  grant.rules_ = std::move(rules);
  return grant;
}

bool Grant::is_public(std::string_view name, const VolumeIdentity& identity) const {
  if (!rules_) return true;
  AccessRules::Subject subject(name, identity);
  return rules_->anyone_.admit(subject);
}

bool Grant::may_read(std::string_view name, const VolumeIdentity& identity) const {
  if (!rules_) return true;
  AccessRules::Subject subject(name, identity);
  const auto is_this = [&](const auto& link) {
    return link.first == identity.kind && link.second == name;
  };
  return rules_->anyone_.admit(subject) || std::ranges::any_of(linked_, is_this) ||
         std::ranges::any_of(patterns_, [&](const AccessRules::Patterns* patterns) {
           return patterns->admit(subject);
         });
}

std::string Grant::key() const {
  if (!rules_) return {};
  std::string key = fmt::format("{}", rules_->id_);
  for (const auto* patterns : patterns_) key += fmt::format(" {}", fmt::ptr(patterns));
  for (const auto& [kind, name] : linked_) key += fmt::format("\n{} {}", word_of(kind), name);
  return key;
}

std::string Grant::client() const {
  if (!client_.empty()) return client_;
  return linked_.empty() ? "" : "link";
}

std::string Grant::quota_client() const {
  return client_ == kServerToken ? std::string() : client_;
}

bool Grant::admits_to_all() const {
  return std::ranges::any_of(patterns_, [](const AccessRules::Patterns* patterns) {
    return std::ranges::any_of(patterns->names, [](const AccessRules::NamePattern& pattern) {
      return pattern.is_all && pattern.is_for_both;
    });
  });
}

bool Grant::has_public_volumes() const {
  return !rules_ || !rules_->anyone_.empty();
}

std::string sign_link(std::string_view key, ServedKind kind, std::string_view name,
                      std::string_view expires) {
  // The first line states the purpose of the signature, so that no link for a volume is one for a
  // scene, whatever their names are.
  const std::string text = fmt::format(
      "isosplat {} 1\n{}\n{}", kind == ServedKind::volume ? "link" : "scene link", name, expires);
  std::array<unsigned char, 32> signature{};
  unsigned int bytes = 0;
  if (!HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
            reinterpret_cast<const unsigned char*>(text.data()), text.size(), signature.data(),
            &bytes) ||
      bytes != signature.size()) {
    return {};
  }
  return hexadecimal(signature);
}

Result<std::string> random_token() {
  std::array<unsigned char, 32> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) {
    return fail(Status::io_error, "no random numbers for a token: is /dev/urandom there?");
  }
  return hexadecimal(bytes);
}

}  // namespace isosplat::server
