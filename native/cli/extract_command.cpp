#include <fmt/format.h>

#include <array>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/extract/extract.h"
#include "native/extract/ply_file.h"

namespace isosplat::cli {
namespace {

struct ExtractCall {
  std::string store, output;
  double isovalue = 0;
  uint32_t level = 0;
  unsigned threads = 0;
  ProjectionOptions projection;
  bool force = false;
};

int run(const ExtractCall& call) {
  const auto store = StoreFile::open(call.store);
  if (!store) return report(store.error());
  const std::filesystem::path path = call.output.empty()
                                         ? std::filesystem::path(call.store).stem().string() +
                                               fmt::format("_{}.ply", call.isovalue)
                                         : call.output;
  if (auto other = check_not_input(path, std::array<std::filesystem::path, 1>{call.store});
      !other) {
    return report(other.error());
  }
  if (auto free = check_replaceable(path, "ply\n", "a PLY file", call.force); !free) {
    return report(free.error());
  }
  auto file = PlyFile::create(
      path, (*store)->info().grid,
      fmt::format("isosurface {} of {}, level {}, by isosplat " ISOSPLAT_VERSION, call.isovalue,
                  std::filesystem::path(call.store).filename().string(), call.level));
  if (!file) return report(file.error());
  const auto points =
      extract_points(**store, call.isovalue, call.projection, {call.level, call.threads},
                     [&](const PointArrays& some) { return file->append(some); });
  if (!points) return report(points.error());
  if (auto published = file->publish(); !published) return report(published.error());
  fmt::print("{}: {} points with normals, {}\n", path.string(), with_commas(*points),
             in_bytes(file->bytes()));
  if (*points == 0) {
    const std::string reason = no_isosurface((*store)->info(), call.isovalue);
    note(!reason.empty()
             ? reason
             : fmt::format("no cell of level {} has a point at {}: what would be active "
                           "there touches voxels without a value",
                           call.level, call.isovalue));
  }
  return kSuccess;
}

}  // namespace

void add_extract_command(CLI::App& program, int& exit_code) {
  CLI::App* command =
      program.add_subcommand("extract", "Write an isosurface as points with normals (PLY)");
  auto call = std::make_shared<ExtractCall>();
  command->add_option("store", call->store, "A store file")->required();
  command->add_option("-i,--isovalue", call->isovalue, "The isovalue, in the volume's values")
      ->check(is_number())
      ->required();
  command->add_option("-o,--output", call->output,
                      "The PLY file (default: the store's name and the isovalue, here)");
  command->add_option("--level", call->level, "0 is the finest; each further one halves each axis")
      ->check(is_whole_number(0, 32))
      ->capture_default_str();
  command->add_flag("--exact", call->projection.exact,
                    "Put points exactly on the trilinear surface where it is met in the cell");
  command->add_flag_callback(
      "--drop-displaced", [call] { call->projection.displaced = Displaced::drop; },
      "Leave out points that one Newton step moves by more than half a cell's longest diagonal\n"
      "(Co, Hamann, Joy 2003, section 3.2), at level 0, and let the others leave their cells");
  command->add_flag("--force", call->force, "Replace the file of that name whatever it is");
  command->add_option("--threads", call->threads, "Threads (0: one per core)")
      ->check(is_whole_number(0, kMaxThreads))
      ->capture_default_str();
  command->footer(
      "There is one point for each active cell, inside of it, as `isosplat render` draws it. On\n"
      "noisy volumes --drop-displaced leaves an eighth of them out, and holes where they "
      "were.\n\n" +
      examples("  isosplat extract engine.isosplat --isovalue 60.5 -o engine.ply\n"
               "  isosplat extract head.isosplat -i -300 --exact --level 1\n"
               "MeshLab, CloudCompare, Open3D and VTK open the file. Positions are in the volume's "
               "world, as doubles where single precision would be off by 1/2000 of a voxel or "
               "more."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
