#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "native/cli/command.h"
#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/cli/write_mesh.h"
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
  std::string shading = "smooth";
  bool mesh = false;
  MeshChanges changes;
  bool force = false;
};

void explain_no_surface(const StoreFile& store, const ExtractCall& call) {
  const std::string reason = no_isosurface(store.info(), call.isovalue);
  note(!reason.empty()
           ? reason
           : fmt::format("no cell of level {} is active at {}: all cells that the isosurface would "
                         "cross touch missing voxels",
                         call.level, call.isovalue));
}

int run(const ExtractCall& call) {
  const auto store = StoreFile::open(call.store);
  if (!store) return report(store.error());
  const std::filesystem::path path = call.output.empty()
                                         ? std::filesystem::path(call.store).stem().string() +
                                               fmt::format("_{}.ply", call.isovalue)
                                         : call.output;
  if (auto checked = check_not_input(path, std::array<std::filesystem::path, 1>{call.store});
      !checked) {
    return report(checked.error());
  }
  // Points are always in a PLY file.
  const auto format = mesh_format(call.mesh ? path : "points.ply");
  if (!format) return report(format.error());
  const auto replaceable =
      check_replaceable(path, (*format)->beginning, (*format)->name, call.force);
  if (!replaceable) return report(replaceable.error());
  const std::string comment =
      fmt::format("isosurface {} of {}, level {}, by isosplat " ISOSPLAT_VERSION, call.isovalue,
                  std::filesystem::path(call.store).filename().string(), call.level);
  if (call.mesh) {
    const auto mesh =
        write_mesh(**store, call.isovalue, {call.level, call.threads}, call.changes, path, comment);
    if (!mesh) return report(mesh.error());
    if (mesh->components_found) {
      note(fmt::format("{} of {} components are kept",
                       with_commas(std::min(*call.changes.components, *mesh->components_found)),
                       with_commas(*mesh->components_found)));
    }
    if (mesh->simplified_within) {
      note(fmt::format("simplified; the largest quadric error (root mean square) is {:.4g}",
                       *mesh->simplified_within));
    }
    fmt::print("{}: {} triangles, {} vertices, {}\n", path.string(),
               with_commas(mesh->counts.triangles), with_commas(mesh->counts.vertices),
               format_bytes(mesh->bytes));
    if (mesh->counts.triangles == 0) explain_no_surface(**store, call);
    return kSuccess;
  }
  auto file = PlyFile::create(path, (*store)->info().grid, comment);
  if (!file) return report(file.error());
  const auto points = extract_points(**store, call.isovalue, call.projection,
                                     {call.level, call.threads, call.shading == "smooth"},
                                     [&](const PointArrays& batch) { return file->append(batch); });
  if (!points) return report(points.error());
  if (auto published = file->publish(); !published) return report(published.error());
  fmt::print("{}: {} points with normals, {}\n", path.string(), with_commas(*points),
             format_bytes(file->bytes()));
  if (*points == 0) explain_no_surface(**store, call);
  return kSuccess;
}

}  // namespace

void add_extract_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "extract", "Write an isosurface as points with normals, or as triangles");
  auto call = std::make_shared<ExtractCall>();
  command->add_option("store", call->store, "A store file")->required();
  command->add_option("-i,--isovalue", call->isovalue, "The isovalue, in the volume's values")
      ->check(is_number())
      ->required();
  command->add_option("-o,--output", call->output,
                      "The file (default: STORE_ISOVALUE.ply in the current folder)");
  command
      ->add_option("--level", call->level, "0 is the finest; each further level halves each axis")
      ->check(is_whole_number(0, 32))
      ->capture_default_str();
  CLI::Option* mesh = command->add_flag(
      "--mesh", call->mesh,
      "Write triangles instead of points: a closed surface (except at the volume's\n"
      "border and at missing voxels), in the format that the extension of --output says:\n" +
          mesh_extensions());
  command
      ->add_option("--components", call->changes.components,
                   "Keep only this number of components, those of the largest areas")
      ->check(is_whole_number(1, std::numeric_limits<uint32_t>::max()))
      ->needs(mesh);
  command
      ->add_flag_callback(
          "--largest", [call] { call->changes.components = 1; }, "The same as --components 1")
      ->needs(mesh)
      ->excludes("--components");
  command
      ->add_option(
          "--simplify", call->changes.simplify_error,
          "Use fewer triangles, with an error of about this length, in the units of the\n"
          "volume's spacing (meshoptimizer's quadric error: the root mean square of distances)")
      ->check(is_above_zero())
      ->needs(mesh);
  command
      ->add_flag("--exact", call->projection.exact,
                 "Place points exactly on the trilinear surface if the ray along the gradient\n"
                 "meets it inside of the cell")
      ->excludes(mesh);
  command
      ->add_flag_callback(
          "--drop-displaced", [call] { call->projection.displaced = Displaced::drop; },
          "Omit points of level 0 that a Newton step moves by more than half a cell's diagonal\n"
          "(Co, Hamann, Joy 2003, section 3.2), and do not clamp the others to their cells")
      ->excludes(mesh);
  command
      ->add_option("--shading", call->shading,
                   "smooth: normals are continuous, from the cells around each point;\n"
                   "exact: the gradient of each cell, which jumps from cell to cell")
      ->check(CLI::IsMember({"smooth", "exact"}))
      ->excludes(mesh)
      ->capture_default_str();
  command->add_flag("--force", call->force, "Replace any file of this name");
  command->add_option("--threads", call->threads, "Threads (0: one per core)")
      ->check(is_whole_number(0, kMaxThreads))
      ->capture_default_str();
  command->footer(
      "Without --mesh, the file has one point for each active cell: the cell's centre, moved onto\n"
      "the surface by one Newton step, but not out of the cell. On noisy volumes --drop-displaced\n"
      "omits about an eighth of the points, which leaves holes.\n"
      "With --mesh, triangles are counter-clockwise seen from the side of smaller values. In PLY,\n"
      "OBJ and GLB files they share vertices, which have smooth normals; STL has a normal for "
      "each\n"
      "triangle, and 3MF has none. Positions are in world space; GLB and 3MF assume millimetres,\n"
      "and GLB converts to metres with y up. In PLY files they are double precision if single\n"
      "precision would be wrong by more than 1/2000 of a voxel.\n\n" +
      examples("  isosplat extract engine.isosplat --isovalue 60.5 -o engine.ply\n"
               "  isosplat extract head.isosplat -i -300 --exact --level 1\n"
               "  isosplat extract engine.isosplat --isovalue 60.5 --mesh -o engine.stl\n"
               "  isosplat extract engine.isosplat -i 60.5 --mesh --largest --simplify 0.1 -o "
               "part.3mf\n"
               "MeshLab, CloudCompare, Open3D and VTK read PLY files."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
