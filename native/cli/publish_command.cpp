#include <fmt/format.h>

#include <algorithm>

#include "native/cli/command.h"
#include "native/cli/options.h"
#include "native/cli/remote_flags.h"
#include "native/cli/serving.h"
#include "native/cli/site.h"
#include "native/cli/site_bucket.h"
#include "native/cli/site_folder.h"
#include "native/cli/terminal.h"
#include "native/remote/remote_target.h"

namespace isosplat::cli {
namespace {

struct PublishCall {
  std::vector<std::string> stores;
  std::string to, web_root;
  bool force = false, prune = false;
  RemoteFlags remote_flags;
};

std::unique_ptr<SitePlace> place_of(const PublishCall& call) {
  if (remote::is_bucket_address(call.to)) {
    return std::make_unique<SiteBucket>(call.to, call.remote_flags);
  }
  return std::make_unique<SiteFolder>(call.to);
}

int run(const PublishCall& call) {
  if (remote::is_address(call.to) && !remote::is_bucket_address(call.to)) {
    return report({Status::invalid_argument,
                   "--to: expected a folder or s3://BUCKET/PREFIX, found an address that cannot be "
                   "written to"});
  }
  SiteOptions options;
  options.stores.assign(call.stores.begin(), call.stores.end());
  const auto place = place_of(call);
  options.place = place.get();
  options.page = find_page(call.web_root);
  options.force = call.force;
  options.prune = call.prune;
  if (options.page.empty()) {
    return report({Status::io_error,
                   "expected the built page beside the program, found none: build it with npm run "
                   "build, or give its folder with --web-root"});
  }
  for (const std::filesystem::path& store : options.stores) {
    std::error_code error;
    if (!std::filesystem::exists(store, error)) {
      return report(
          {Status::io_error, fmt::format("{}: expected a store, a scene or a folder of them, "
                                         "found nothing: check the path, or build a store with "
                                         "isosplat build",
                                         store.string())});
    }
  }
  ProgressLine line("Publishing");
  options.progress = [&](uint64_t done, uint64_t all) {
    line.show(static_cast<double>(done) / static_cast<double>(std::max<uint64_t>(all, 1)),
              "copying stores");
  };
  const auto site = publish_site(options);
  line.clear();
  if (!site) return report(site.error());
  size_t volumes = 0, scenes = 0;
  for (const SiteFile& file : site->files) {
    ++(file.kind == server::ServedKind::volume ? volumes : scenes);
    fmt::print("{}: {}{}\n", file.name, file.file, file.is_new ? "" : " (unchanged)");
  }
  for (const std::filesystem::path& path : site->pruned) {
    fmt::print("removed {}\n", path.string());
  }
  const auto counted = [](size_t count, std::string_view word) {
    return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s");
  };
  std::string listed = counted(volumes, "volume");
  if (scenes > 0) {
    listed = volumes > 0 ? counted(scenes, "scene") + " and " + listed : counted(scenes, "scene");
  }
  fmt::print("{}: a site of {}{}\n", call.to, listed,
             remote::is_bucket_address(call.to)
                 ? ""
                 : ": copy it to any web host that supports range requests");
  return kSuccess;
}

}  // namespace

void add_publish_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "publish", "Write a static web site: the page, a catalog, stores and scenes");
  auto call = std::make_shared<PublishCall>();
  command
      ->add_option(
          "stores", call->stores,
          "Stores (*.isosplat), scenes (*.isobundle, scene.json, *.scene.json), and folders "
          "with such files")
      ->required();
  command
      ->add_option(
          "--to", call->to,
          "Folder of the site, which is created if it does not exist, or s3://BUCKET/PREFIX")
      ->required();
  command->add_option("--web-root", call->web_root,
                      "Folder with the page (default: the page built with this program)");
  command->add_flag("--prune", call->prune,
                    "Remove stores, scenes and assets that the site does not use");
  command->add_flag("--force", call->force,
                    "Write into the folder even if it contains other files than a site");
  call->remote_flags.add_to(*command);
  command->footer(examples(
      "  isosplat publish engine.isosplat head.isosplat --to site\n"
      "  isosplat publish stores/ --to site --prune\n"
      "  isosplat publish run.isobundle --to site\n"
      "  isosplat publish stores/ --to s3://bucket/site\n"
      "A scene is published as one file, a bundle. Stores that a scene.json names are in it.\n"
      "Any web host that supports range requests can serve the site: nginx, Caddy, or a bucket.\n"
      "The host needs no program of Isosplat. Everyone who can reach the host can read all "
      "volumes.\n"
      "To update a site, publish it again: only new and changed stores are copied. The file name "
      "of\n"
      "a store contains its content id, so caches may keep the file for ever."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
