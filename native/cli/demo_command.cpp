#include <fmt/format.h>

#include <thread>

#include "native/cli/command.h"
#include "native/cli/options.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/demo/demo_volumes.h"
#include "native/files/output_file.h"

namespace isosplat::cli {
namespace {

struct DemoCall {
  std::string folder, output;
  std::vector<std::string> names;
  bool force = false;
};

Result<void> write(const DemoVolume& volume, const std::filesystem::path& path, bool force) {
  const std::string header = demo_nrrd_header(volume);
  if (auto checked = check_replaceable(path, header, "this demo volume", force); !checked) {
    return checked;
  }
  auto file = OutputFile::create(path);
  if (!file) return tl::unexpected(file.error());
  auto written = file->write(0, std::as_bytes(std::span(header)));
  if (written) written = file->write(header.size(), std::as_bytes(std::span(volume.values)));
  if (!written) return written;
  return file->publish();
}

int run(const DemoCall& call) {
  const std::filesystem::path folder = !call.output.empty()   ? call.output
                                       : !call.folder.empty() ? call.folder
                                                              : ".";
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return report({Status::io_error, fmt::format("{}: cannot create the folder: {}",
                                                 folder.string(), error.message())});
  }
  std::vector<std::string> names = call.names;
  if (names.empty()) names.assign(demo_names().begin(), demo_names().end());
  for (const std::string& name : names) {
    const auto volume = make_demo(name, std::max(1u, std::thread::hardware_concurrency()));
    if (!volume) {
      return report({Status::invalid_argument, volume.error().message});
    }
    const std::filesystem::path path = folder / (name + ".nrrd");
    if (auto written = write(*volume, path, call.force); !written) return report(written.error());
    fmt::print("{}: {}, {} × {} × {} voxels\n", path.string(), volume->title, volume->voxels.x,
               volume->voxels.y, volume->voxels.z);
  }
  return kSuccess;
}

}  // namespace

void add_demo_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand("demo", "Generate example volumes");
  auto call = std::make_shared<DemoCall>();
  command->add_option("folder", call->folder, "Output folder (default: the current one)");
  command->add_option("-o,--output", call->output, "The same as folder")->excludes("folder");
  command
      ->add_option("--only", call->names,
                   "Volumes to generate: bucky, marschner_lobb, mandelbulb (default: all)")
      ->delimiter(',');
  command->add_flag("--force", call->force,
                    "Replace files of these names even if they are not demo volumes");
  command->footer(
      examples("  isosplat demo volumes\n"
               "  isosplat demo --only mandelbulb && isosplat view mandelbulb.nrrd\n"
               "The files are identical on all machines."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
