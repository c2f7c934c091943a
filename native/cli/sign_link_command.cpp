#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <vector>

#include "native/cli/command.h"
#include "native/cli/durations.h"
#include "native/cli/options.h"
#include "native/cli/terminal.h"
#include "server/access/access_rules.h"
#include "server/catalog/catalog.h"
#include "server/catalog/volume_names.h"

namespace isosplat::cli {
namespace {

struct SignCall {
  std::string volume, key_file, expires = "7d", url = "http://localhost:8080/";
  std::vector<std::string> folders;
};

Result<std::string> read_key(const std::string& file) {
  std::string key;
  if (!file.empty()) {
    std::ifstream stream(file, std::ios::binary);
    key.assign(std::istreambuf_iterator<char>(stream), {});
    if (!stream) {
      return fail(Status::io_error, fmt::format("{}: expected a file with the key, cannot read it: "
                                                "check the path and its permissions",
                                                file));
    }
  } else if (const char* given = std::getenv("ISOSPLAT_LINK_KEY"); given && *given) {
    key = given;
  } else {
    return fail(Status::invalid_argument,
                "expected the server's key in --link-key-file or ISOSPLAT_LINK_KEY, found neither");
  }
  while (key.ends_with('\n') || key.ends_with('\r')) key.pop_back();
  // The server has the same limits.
  if (Result<void> valid = server::AccessRules().set_link_key(key); !valid) {
    return tl::unexpected(valid.error());
  }
  return key;
}

/// The name that the server gives to a store in the served folders.
Result<std::string> name_in_folders(const SignCall& call) {
  namespace fs = std::filesystem;
  std::error_code error;
  // Only links of the folder are resolved: the name is that of the served link.
  const fs::path store = fs::weakly_canonical(fs::absolute(call.volume).parent_path(), error) /
                         fs::path(call.volume).filename();
  server::Catalog catalog({call.folders.begin(), call.folders.end()}, [](std::string_view) {});
  catalog.scan();
  const std::shared_ptr<const server::CatalogSnapshot> snapshot = catalog.snapshot();
  for (const auto& [name, entry] : *snapshot) {
    if (fs::path(entry->folder) / entry->file == store) return name;
  }
  return fail(Status::invalid_argument,
              fmt::format("{}: expected a store (*{}) in {} or a subfolder, found none: check the "
                          "path and --folder",
                          call.volume, server::kStoreExtension, fmt::join(call.folders, " or ")));
}

/// The name on the server of the volume, which was given by its name or its store.
Result<std::string> name_of(const SignCall& call) {
  if (!call.folders.empty()) return name_in_folders(call);
  const bool is_store =
      call.volume.find('/') != std::string::npos || call.volume.ends_with(server::kStoreExtension);
  if (!is_store && server::is_volume_name(call.volume)) return call.volume;
  // Another store may have the name that this store would have without the other one.
  return fail(Status::invalid_argument,
              fmt::format("{}: expected the name of a volume as the server lists it. For the path "
                          "of a store, give each folder or store that is served with --folder",
                          call.volume));
}

int run(const SignCall& call) {
  const auto seconds = parse_duration(call.expires);
  if (!seconds) {
    return report({Status::invalid_argument,
                   fmt::format("--expires: expected a time such as 30m, 12h or 7d (at most 3650d), "
                               "found '{}'",
                               call.expires)});
  }
  const auto volume = name_of(call);
  if (!volume) return report(volume.error());
  const std::string& name = *volume;
  const auto key = read_key(call.key_file);
  if (!key) return report(key.error());
  const std::string expires = std::to_string(std::time(nullptr) + *seconds);
  const std::string signature = server::sign_link(*key, name, expires);
  if (signature.empty()) {
    return report({Status::io_error, "HMAC-SHA-256 is not available: check OpenSSL"});
  }
  fmt::print("{}{}?volume={}&exp={}&sig={}\n", call.url, call.url.ends_with('/') ? "" : "/", name,
             expires, signature);
  return kSuccess;
}

}  // namespace

void add_sign_link_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "sign-link", "Print a link that grants access to one volume for a limited time");
  auto call = std::make_shared<SignCall>();
  command->add_option("volume", call->volume, "The volume's name on the server, or its store")
      ->required();
  command
      ->add_option("--folder", call->folders,
                   "Folder or store that the server was started with. Needed if the volume is "
                   "given by its store; may be repeated")
      ->check(CLI::ExistingPath)
      ->allow_extra_args(false);
  command->add_option("--link-key-file", call->key_file,
                      "File with the server's key (default: the key in ISOSPLAT_LINK_KEY)");
  command
      ->add_option("--expires", call->expires, "How long the link is valid, such as 30m, 12h or 7d")
      ->capture_default_str();
  command->add_option("--url", call->url, "Address of the server's page")->capture_default_str();
  command->footer(examples(
      "  isosplat sign-link head --link-key-file key.txt --expires 12h\n"
      "  isosplat sign-link head --link-key-file key.txt --url https://a.example/\n"
      "  isosplat sign-link ct~head --link-key-file key.txt\n"
      "  isosplat sign-link stores/ct/head.isosplat --folder stores --link-key-file key.txt\n"
      "openssl rand -hex 32 > key.txt makes a key for isosplat serve --link-key-file key.txt.\n"
      "Whoever has the link can read the volume until the link expires. To revoke a link, write "
      "the\n"
      "first 16 digits of its sig on a line of the server's file --revoked-links. A new key "
      "revokes\n"
      "all links."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
