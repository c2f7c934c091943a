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
  bool is_scene = false;
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

/// What a link is for.
struct Signed {
  server::ServedKind kind = server::ServedKind::volume;
  std::string name;
};

/// The name that the server gives to a store or a scene in the served folders.
Result<Signed> name_in_folders(const SignCall& call) {
  namespace fs = std::filesystem;
  std::error_code error;
  // Only links of the folder are resolved: the name is that of the served link.
  const fs::path store = fs::weakly_canonical(fs::absolute(call.volume).parent_path(), error) /
                         fs::path(call.volume).filename();
  server::Catalog catalog({call.folders.begin(), call.folders.end()}, [](std::string_view) {});
  catalog.scan();
  const bool is_scene = server::is_scene_file(store.filename().native());
  const auto kind = is_scene ? server::ServedKind::scene : server::ServedKind::volume;
  const std::shared_ptr<const server::CatalogSnapshot> snapshot = catalog.snapshot(kind);
  for (const auto& [name, entry] : *snapshot) {
    if (fs::path(entry->folder) / entry->file == store) return Signed{kind, name};
  }
  return fail(
      Status::invalid_argument,
      fmt::format("{}: expected a store (*{}) or a scene (*{}, scene.json, *.scene.json) in "
                  "{} or a subfolder, found none: check the path and --folder",
                  call.volume, server::kStoreExtension, server::kBundleExtension,
                  fmt::join(call.folders, " or ")));
}

/// The name on the server of the volume or the scene, which was given by its name or its file.
Result<Signed> name_of(const SignCall& call) {
  if (!call.folders.empty()) return name_in_folders(call);
  const bool is_file = call.volume.find('/') != std::string::npos ||
                       call.volume.ends_with(server::kStoreExtension) ||
                       server::is_scene_file(call.volume);
  if (!is_file && server::is_volume_name(call.volume)) {
    return Signed{call.is_scene ? server::ServedKind::scene : server::ServedKind::volume,
                  call.volume};
  }
  // Another store may have the name that this store would have without the other one.
  return fail(
      Status::invalid_argument,
      fmt::format("{}: expected the name of a volume or a scene as the server lists it. For "
                  "the path of a file, give each folder or file that is served with "
                  "--folder",
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
  const auto named = name_of(call);
  if (!named) return report(named.error());
  const auto& [kind, name] = *named;
  const auto key = read_key(call.key_file);
  if (!key) return report(key.error());
  const std::string expires = std::to_string(std::time(nullptr) + *seconds);
  const std::string signature = server::sign_link(*key, kind, name, expires);
  if (signature.empty()) {
    return report({Status::io_error, "HMAC-SHA-256 is not available: check OpenSSL"});
  }
  fmt::print("{}{}?{}={}&exp={}&sig={}\n", call.url, call.url.ends_with('/') ? "" : "/",
             server::word_of(kind), name, expires, signature);
  return kSuccess;
}

}  // namespace

void add_sign_link_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "sign-link", "Print a link that grants access to one volume or scene for a limited time");
  auto call = std::make_shared<SignCall>();
  command
      ->add_option("volume", call->volume,
                   "The volume's or scene's name on the server, or its file")
      ->required();
  command->add_flag("--scene", call->is_scene, "The name is that of a scene");
  command
      ->add_option("--folder", call->folders,
                   "Folder or file that the server was started with. Needed if the volume or scene "
                   "is given by its file; may be repeated")
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
      "  isosplat sign-link run --scene --link-key-file key.txt\n"
      "  isosplat sign-link stores/ct/head.isosplat --folder stores --link-key-file key.txt\n"
      "openssl rand -hex 32 > key.txt makes a key for isosplat serve --link-key-file key.txt.\n"
      "Whoever has the link can read the volume or scene until the link expires. To revoke a link, "
      "write "
      "the\n"
      "first 16 digits of its sig on a line of the server's file --revoked-links. A new key "
      "revokes\n"
      "all links."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
