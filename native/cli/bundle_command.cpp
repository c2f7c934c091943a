#include <fmt/format.h>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/scene/bundle.h"

namespace isosplat::cli {
namespace {

struct BundleCall {
  std::string input, output;
  bool force = false;
};

int run_bundle(const BundleCall& call) {
  const auto scene = SceneFile::open(call.input);
  if (!scene) return report(scene.error());
  if (scene->is_bundle()) {
    return report(
        {Status::invalid_argument, fmt::format("{}: expected a scene, found a bundle, which "
                                               "already contains its stores: copy the file",
                                               call.input)});
  }
  const std::filesystem::path output = call.output,
                              folder = std::filesystem::path(call.input).parent_path();
  std::vector<std::filesystem::path> inputs{call.input};
  for (const std::string& store : store_paths(scene->scene())) inputs.push_back(folder / store);
  if (auto checked = check_not_input(output, inputs); !checked) return report(checked.error());
  if (auto checked = check_replaceable_bundle(output, call.force); !checked) {
    return report(checked.error());
  }
  const auto bytes = write_bundle(*scene, output);
  if (!bytes) return report(bytes.error());
  fmt::print("{}: {} layers, {} stores, {}\n", call.output, scene->scene().layers.size(),
             store_paths(scene->scene()).size(), format_bytes(*bytes));
  return kSuccess;
}

int run_unbundle(const BundleCall& call) {
  const auto bundle = SceneFile::open(call.input);
  if (!bundle) return report(bundle.error());
  if (!bundle->is_bundle()) {
    return report(
        {Status::invalid_argument,
         fmt::format(
             "{}: expected a bundle, found a scene: isosplat bundle makes a bundle of a scene",
             call.input)});
  }
  const auto files = unbundle(*bundle, call.output, call.force);
  if (!files) return report(files.error());
  fmt::print("{}: {} files\n", call.output, *files);
  return kSuccess;
}

}  // namespace

void add_bundle_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand("bundle", "Put a scene and its stores into one file");
  auto call = std::make_shared<BundleCall>();
  command->add_option("scene", call->input, "The scene (a JSON file)")->required();
  command->add_option("-o,--output", call->output, "The bundle, such as head.isobundle")
      ->required();
  command->add_flag("--force", call->force, "Replace any file of this name");
  command->footer(examples("  isosplat bundle scene.json -o head.isobundle\n"));
  command->callback([call, &exit_code] { exit_code = run_bundle(*call); });
}

void add_unbundle_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "unbundle", "Write the scene and the stores of a bundle into a folder");
  auto call = std::make_shared<BundleCall>();
  command->add_option("bundle", call->input, "A bundle")->required();
  command->add_option("-o,--output", call->output, "The folder")->required();
  command->add_flag("--force", call->force, "Replace files of these names");
  command->footer(examples("  isosplat unbundle head.isobundle -o head/\n"));
  command->callback([call, &exit_code] { exit_code = run_unbundle(*call); });
}

}  // namespace isosplat::cli
