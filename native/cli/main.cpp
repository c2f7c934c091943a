#include <isosplat/version.h>

#include "native/cli/command.h"
#include "native/cli/program.h"

int main(int argc, char** argv) {
  isosplat::cli::handle_signals();
  CLI::App program(
      "Isosplat builds stores from volumes and shows their isosurfaces in a browser, for any "
      "isovalue.",
      "isosplat");
  program.set_version_flag("--version", "isosplat " ISOSPLAT_VERSION);
  program.require_subcommand(1);
  program.footer(
      "Examples:\n"
      "  isosplat view head.nii.gz           show a volume in the browser\n"
      "  isosplat build scan/ -o scan.isosplat\n"
      "                                      build a store from a DICOM folder\n"
      "  isosplat serve stores/              serve all stores of a folder\n"
      "  isosplat COMMAND --help             the options of a command, with examples");

  int exit_code = isosplat::cli::kSuccess;
  isosplat::cli::add_build_command(program, exit_code);
  isosplat::cli::add_join_command(program, exit_code);
  isosplat::cli::add_info_command(program, exit_code);
  isosplat::cli::add_serve_command(program, exit_code);
  isosplat::cli::add_health_command(program, exit_code);
  isosplat::cli::add_view_command(program, exit_code);
  isosplat::cli::add_publish_command(program, exit_code);
  isosplat::cli::add_sign_link_command(program, exit_code);
  isosplat::cli::add_extract_command(program, exit_code);
  isosplat::cli::add_render_command(program, exit_code);
  isosplat::cli::add_verify_command(program, exit_code);
  isosplat::cli::add_bundle_command(program, exit_code);
  isosplat::cli::add_unbundle_command(program, exit_code);
  isosplat::cli::add_demo_command(program, exit_code);
  return isosplat::cli::run_program(program, argc, argv, exit_code);
}
