#include "native/remote/aws_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>

namespace isosplat::remote {
namespace {

using Profile = std::map<std::string, std::string, std::less<>>;

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value ? value : "";
}

std::string first_of(std::initializer_list<std::string> texts) {
  for (const std::string& text : texts) {
    if (!text.empty()) return text;
  }
  return {};
}

std::string value_at(const Profile& profile, std::string_view key) {
  const auto found = profile.find(key);
  return found == profile.end() ? std::string() : found->second;
}

std::string trimmed(std::string_view text) {
  constexpr std::string_view kSpaces = " \t\r";
  const size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string_view::npos) return {};
  return std::string(text.substr(begin, text.find_last_not_of(kSpaces) + 1 - begin));
}

std::string path_of(const char* variable_name, const char* file) {
  const std::string path = variable(variable_name), home = variable("HOME");
  if (!path.empty()) return path;
  return home.empty() ? std::string() : home + "/.aws/" + file;
}

/// Adds the keys of [section] in a file of lines "key = value"; indented lines, which belong to
/// nested settings, are ignored. Returns whether the section exists.
bool read_section(const std::string& path, const std::string& section, Profile& profile) {
  std::ifstream file(path);
  std::string line;
  bool is_inside = false, exists = false;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#' || line[0] == ';' || line[0] == ' ' || line[0] == '\t') {
      continue;
    }
    if (line[0] == '[') {
      is_inside = trimmed(line.substr(1, line.find(']') - 1)) == section;
      exists = exists || is_inside;
      continue;
    }
    const size_t equals = line.find('=');
    if (!is_inside || equals == std::string::npos) continue;
    // The first file that has a key decides.
    profile.emplace(trimmed(line.substr(0, equals)), trimmed(line.substr(equals + 1)));
  }
  return exists;
}

Result<Profile> read_profile() {
  const std::string chosen = first_of({variable("AWS_PROFILE"), variable("AWS_DEFAULT_PROFILE")});
  const std::string name = chosen.empty() ? "default" : chosen;
  Profile profile;
  const std::string config = path_of("AWS_CONFIG_FILE", "config");
  bool exists = read_section(path_of("AWS_SHARED_CREDENTIALS_FILE", "credentials"), name, profile);
  exists = read_section(config, "profile " + name, profile) || exists;
  if (name == "default") exists = read_section(config, name, profile) || exists;
  if (exists || chosen.empty()) return profile;
  return fail(Status::invalid_argument,
              fmt::format("AWS_PROFILE: expected a profile of ~/.aws/credentials or ~/.aws/config, "
                          "found '{}', which neither has: choose another one",
                          name));
}

Result<void> check(const AwsSignature& signature, const std::string& source) {
  const auto wrong = [&](const char* found) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected an access key and its secret key, found {}: check the "
                            "credentials",
                            source, found));
  };
  if (signature.access_key.empty()) return wrong("no access key");
  if (signature.secret_key.empty()) return wrong("no secret key");
  const auto has_control = [](const std::string& text) {
    return std::ranges::any_of(text, [](char c) { return c > 0 && (c < ' ' || c == 127); });
  };
  // They become headers of requests.
  if (has_control(signature.access_key) || has_control(signature.session_token) ||
      has_control(signature.region)) {
    return wrong("control characters");
  }
  return {};
}

/// The key of a profile that gets its credentials elsewhere. Empty if there is none.
std::string other_source(const Profile& profile) {
  for (const char* key : {"credential_process", "role_arn", "sso_session", "sso_start_url",
                          "web_identity_token_file"}) {
    if (profile.contains(key)) return key;
  }
  return {};
}

}  // namespace

Result<AwsSettings> load_aws_settings() {
  const auto profile = read_profile();
  if (!profile) return tl::unexpected(profile.error());
  AwsSettings settings;
  settings.region = first_of({variable("AWS_REGION"), variable("AWS_DEFAULT_REGION"),
                              value_at(*profile, "region"), "us-east-1"});
  settings.endpoint = first_of({variable("AWS_ENDPOINT_URL_S3"), variable("AWS_ENDPOINT_URL"),
                                value_at(*profile, "endpoint_url")});
  AwsSignature signature{settings.region, variable("AWS_ACCESS_KEY_ID"),
                         variable("AWS_SECRET_ACCESS_KEY"), variable("AWS_SESSION_TOKEN")};
  std::string source = "AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY";
  if (signature.access_key.empty() && signature.secret_key.empty()) {
    signature.access_key = value_at(*profile, "aws_access_key_id");
    signature.secret_key = value_at(*profile, "aws_secret_access_key");
    signature.session_token = value_at(*profile, "aws_session_token");
    source = "the profile of AWS";
  }
  if (signature.access_key.empty() && signature.secret_key.empty()) {
    const std::string other = other_source(*profile);
    if (other.empty()) return settings;  // anonymous
    return fail(Status::invalid_argument,
                fmt::format("the profile of AWS: expected aws_access_key_id, found {}, which is "
                            "not supported: run eval \"$(aws configure export-credentials "
                            "--format env)\" before",
                            other));
  }
  if (auto checked = check(signature, source); !checked) return tl::unexpected(checked.error());
  settings.signature = std::make_shared<const AwsSignature>(std::move(signature));
  return settings;
}

}  // namespace isosplat::remote
