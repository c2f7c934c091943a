#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/access/jwt.h"
#include "server/catalog/volume_names.h"
#include "shared/core/base/status.h"

namespace isosplat::server {

/// The credentials of a request. The views refer to the request and its target.
struct Credentials {
  /// A signed link: everyone who has it may read one volume or scene until it expires.
  struct Link {
    ServedKind kind = ServedKind::volume;
    std::string_view name;
    std::string_view expires;    ///< seconds since 1970, decimal
    std::string_view signature;  ///< of all three, as sign_link() makes it
  };
  std::vector<std::string_view> tokens;
  std::vector<Link> links;
  Identity identity{};  ///< as stated by a trusted proxy; without a user: none
};

class Grant;

/// Who may read which volumes and scenes. Without tokens and without a key for links, everyone may
/// read everything. Thread-safe once it is filled.
class AccessRules {
 public:
  AccessRules();

  /// Adds the rules of a token file. Each line has a subject and one or more patterns, separated by
  /// blanks. The subject is a token, the word "anyone", or "user:" or "group:" and a name of an
  /// Identity ("*" and "?": any characters). A token may be followed by "name=" and a name for
  /// the log. Without it, the name is "line-" and the number of the line.
  ///
  /// A pattern without "/" is compared with volumes segment by segment. A segment that could be a
  /// segment of a name is compared with the name. Any other segment, such as one with "*" and "?",
  /// is compared with the path of the store, before it was converted to a name. "*" alone grants
  /// access to all volumes, and a pattern that ends with "~*" to all volumes below the folder. A
  /// pattern with "/" is a folder or a store on the disk, and grants access to the stores in and
  /// below this folder, or to this store.
  ///
  /// "*", patterns that end with "~*", and folders hold for volumes and scenes: a scene's stores
  /// are in its folder or below, so these patterns admit to the stores as well. All other patterns
  /// without "/" refer to volumes only. Patterns that begin with "scene:" refer to scenes only. A
  /// right to read a scene includes its stores, but only as parts of the scene.
  ///
  /// Empty lines and lines that begin with "#" are ignored. Errors (invalid_argument) name the
  /// line, not the token.
  Result<void> add_lines(std::string_view text);

  /// Adds a token for all volumes. `name`: for the log. Errors (invalid_argument): fewer than
  /// kMinTokenLength characters, or characters other than letters, digits and "-._~+/=".
  Result<void> add_token(std::string_view token, std::string name);

  /// Sets the key of signed links. Errors (invalid_argument): fewer than kMinKeyLength bytes.
  Result<void> set_link_key(std::string_view key);

  /// Sets the verifier of tokens that are JWTs.
  void set_jwt_verifier(std::shared_ptr<const JwtVerifier> verifier) {
    jwt_verifier_ = std::move(verifier);
  }

  /// Revokes links: each line has a signature, or its first kLinkIdLength digits. Empty lines, and
  /// text behind "#" or a blank, are ignored. Errors (invalid_argument) name the line.
  Result<void> add_revoked_links(std::string_view text);

  /// From now on, only clients with a right may read volumes.
  void close() { has_lines_ = true; }

  /// Whether there is a rule for users or groups.
  bool has_identity_rules() const { return !identity_rules_.empty(); }

  /// Whether every client may read every volume.
  bool is_open() const {
    return rules_.empty() && link_key_.empty() && !has_lines_ && !jwt_verifier_;
  }

  /// The rights of a client with these credentials at `now` (seconds since 1970). Tokens and
  /// signatures are compared in constant time. `rules`: null is the same as open.
  static Grant grant(std::shared_ptr<const AccessRules> rules, const Credentials& credentials,
                     uint64_t now);

  static constexpr size_t kMinTokenLength = 16;
  static constexpr size_t kMinKeyLength = 32;
  static constexpr size_t kLinkIdLength = 16;

 private:
  friend class Grant;

  /// A pattern for names.
  struct NamePattern {
    ServedKind kind = ServedKind::volume;  ///< unless it holds for both
    std::string text;
    std::vector<std::string> segments;  ///< empty: compared with the whole name
    bool is_all = false;
    bool is_for_both = false;  ///< for volumes and scenes
    bool goes_below = false;   ///< its last segment, "*", stands for one or more
  };
  class Subject;

  /// Patterns of names, and paths on the disk.
  struct Patterns {
    std::vector<NamePattern> names;
    std::vector<std::string> folders;  ///< absolute, without "/" at the end
    std::vector<std::string> stores;   ///< absolute
    bool empty() const { return names.empty() && folders.empty() && stores.empty(); }
    bool admit(Subject& subject) const;
    Result<void> add(std::string_view pattern);
  };
  using Digest = std::array<unsigned char, 32>;
  struct Rule {
    Digest
        token;  ///< SHA-256. All digests have the same length, so the comparison does not leak it
    std::string name;
    Patterns patterns;
  };

  struct IdentityRule {
    bool is_group;
    std::string pattern;
    Patterns patterns;
  };
  void admit_identity(const Identity& identity, Grant& grant) const;

  std::vector<Rule> rules_;
  std::vector<IdentityRule> identity_rules_;
  std::shared_ptr<const JwtVerifier> jwt_verifier_;     ///< null: no JWT is valid
  std::set<std::string, std::less<>> revoked_links_{};  ///< first digits of signatures
  Patterns anyone_;
  std::string link_key_;
  uint64_t id_ = 0;         ///< of these rules; unique in this process
  bool has_lines_ = false;  ///< a token file was given: even an empty one closes the server
};

/// The name of the token that is not in the token file.
inline constexpr std::string_view kServerToken = "ISOSPLAT_TOKEN";

/// The rights of one client.
class Grant {
 public:
  /// Whether the client may read a volume or a scene (identity.kind). The time does not depend on
  /// whether it exists.
  bool may_read(std::string_view name, const VolumeIdentity& identity) const;

  /// Whether every client may read it, so that shared caches may store it.
  bool is_public(std::string_view name, const VolumeIdentity& identity) const;

  /// The name of the valid token, "user:" and the name of an identity, or "link" for a link; empty
  /// if there is none.
  std::string client() const;

  /// The client to which rates and shares of the server apply: client() for a token of the file and
  /// for an identity. Empty for all others, to whose address they apply: many clients may have
  /// kServerToken.
  std::string quota_client() const;

  /// A text that is equal for two grants if and only if they give access to the same volumes by the
  /// same rules.
  std::string key() const;

  /// Whether a token or link was valid, or none is needed for any volume.
  bool is_known() const { return is_known_; }

  /// Whether a token was valid.
  bool has_token() const { return !patterns_.empty(); }

  /// Whether a token for all volumes and scenes ("*") was valid.
  bool admits_to_all() const;

  /// Whether some volumes may be read by anyone.
  bool has_public_volumes() const;

 private:
  friend class AccessRules;
  std::shared_ptr<const AccessRules> rules_;  ///< null: open
  std::vector<const AccessRules::Patterns*> patterns_;
  std::string client_;
  std::vector<std::pair<ServedKind, std::string>> linked_;  ///< kinds and names
  bool is_known_ = true;
  bool has_identity_ = false;
};

/// The signature of a link: the HMAC-SHA-256 of the kind, the name and the time, as 64 hexadecimal
/// digits.
std::string sign_link(std::string_view key, ServedKind kind, std::string_view name,
                      std::string_view expires);

/// A token of 256 random bits, as hexadecimal digits. Errors: io_error (no source of randomness).
Result<std::string> random_token();

}  // namespace isosplat::server
