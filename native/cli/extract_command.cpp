#include <fmt/format.h>
#include <isosplat/version.h>

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
#include "native/extract/mesh_file.h"

namespace isosplat::cli {
namespace {

struct ExtractCall {
  std::string store, output;
  double isovalue = 0;
  uint32_t level = 0;
  unsigned threads = 0;
  ProjectionOptions projection;
  std::string shading = "smooth";
  std::vector<double> box;
  bool mesh = false;
  MeshChanges changes;
  bool force = false;
};

/// The cells of --box; no value if the option is not given.
Result<std::optional<CellRegion>> region_of(const ExtractCall& call, const VolumeGrid& grid) {
  if (call.box.empty()) return std::nullopt;
  const Vec3d low{call.box[0], call.box[1], call.box[2]};
  const Vec3d high{call.box[3], call.box[4], call.box[5]};
  if (low.x < high.x && low.y < high.y && low.z < high.z) {
    return CellRegion::in_world(grid, low, high);
  }
  return fail(Status::invalid_argument,
              fmt::format("expected --box X0,Y0,Z0,X1,Y1,Z1 with X0 < X1, Y0 < Y1 and Z0 < Z1, "
                          "found {}: swap the coordinates that are in the wrong order",
                          fmt::join(call.box, ",")));
}

void explain_no_surface(const StoreFile& store, const ExtractCall& call) {
  const std::string reason = no_isosurface(store.info(), call.isovalue);
  note(!reason.empty() ? reason
       : !call.box.empty()
           ? fmt::format("no cell of level {} in --box is active at {}: isosplat info prints the "
                         "volume's origin and spacing in world units",
                         call.level, call.isovalue)
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
  const auto format =
      mesh_format(path, call.mesh ? SurfaceContent::triangles : SurfaceContent::points);
  if (!format) return report(format.error());
  const auto replaceable =
      check_replaceable(path, (*format)->beginning, (*format)->name, call.force);
  if (!replaceable) return report(replaceable.error());
  const auto region = region_of(call, (*store)->info().grid);
  if (!region) return report(region.error());
  const ExtractOptions options{call.level, call.threads, call.shading == "smooth", *region};
  const std::string comment =
      fmt::format("isosurface {} of {}, level {}, by isosplat " ISOSPLAT_VERSION, call.isovalue,
                  std::filesystem::path(call.store).filename().string(), call.level);
  if (call.mesh) {
    const auto mesh = write_mesh(**store, call.isovalue, options, call.changes, path, comment);
    if (!mesh) return report(mesh.error());
    if (mesh->components_found) {
      note(fmt::format("kept {} of {} components",
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
  const auto file = (*format)->create(
      path, {(*store)->info().grid, call.isovalue, comment, SurfaceContent::points});
  if (!file) return report(file.error());
  const auto points = extract_points(**store, call.isovalue, call.projection, options,
                                     [&](const PointArrays& batch) {
                                       return (*file)->append({batch, {}});
                                     });
  if (!points) return report(points.error());
  if (auto published = (*file)->publish(); !published) return report(published.error());
  fmt::print("{}: {} points with normals, {}\n", path.string(), with_commas(*points),
             format_bytes((*file)->bytes()));
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
  command->add_option(
      "-o,--output", call->output,
      "The file (default: STORE_ISOVALUE.ply in the current folder); its extension\n"
      "determines the format. Points: " +
          mesh_extensions(SurfaceContent::points) +
          "; triangles: " + mesh_extensions(SurfaceContent::triangles));
  command
      ->add_option("--level", call->level,
                   "Level of detail: 0 is the finest, and each further level halves the resolution "
                   "of each axis")
      ->check(is_whole_number(0, 32))
      ->capture_default_str();
  command
      ->add_option(
          "--box", call->box,
          "X0,Y0,Z0,X1,Y1,Z1 in world units: extract only cells whose centres are in this box")
      ->delimiter(',')
      ->check(is_number())
      ->expected(6);
  CLI::Option* mesh = command->add_flag(
      "--mesh", call->mesh,
      "Write triangles instead of points: a closed surface (except at the volume's\n"
      "border and at missing voxels)");
  command
      ->add_option("--components", call->changes.components,
                   "Keep only this many connected components, those with the largest areas")
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
      ->add_option(
          "--shading", call->shading,
          "smooth: normals are continuous, computed from the cells around each point;\n"
          "exact: normals are the gradients of the cells, which differ between adjacent cells")
      ->check(CLI::IsMember({"smooth", "exact"}))
      ->excludes(mesh)
      ->capture_default_str();
  command->add_flag("--force", call->force, "Replace any file of this name");
  command->add_option("--threads", call->threads, "Number of threads (0: one per core)")
      ->check(is_whole_number(0, kMaxThreads))
      ->capture_default_str();
  command->footer(
      "Without --mesh, the file has one point for each active cell: the cell's centre, moved onto\n"
      "the surface by one Newton step, but not out of the cell. On noisy volumes --drop-displaced\n"
      "omits about an eighth of the points, which leaves holes.\n"
      "With --mesh, triangles are counter-clockwise seen from the side of smaller values. In PLY,\n"
      "OBJ and GLB files they share vertices, which have smooth normals; STL has a normal for "
      "each\n"
      "triangle, and 3MF has none. Positions are in world space. For GLB and 3MF the unit is "
      "assumed\n"
      "to be the millimetre, and GLB positions are converted to metres, with y up. PLY files "
      "store\n"
      "positions in double precision if single precision would be wrong by more than 1/2000 of a "
      "voxel.\n"
      "NumPy loads .npy and .npz: an .npy file has one array of points with the fields position,\n"
      "normal and value. An .npz file has the arrays positions, normals and isovalue, and with "
      "--mesh the\n"
      "array triangles.\n"
      "With --box, the surface ends at faces of cells. It is open there, as it is at the volume's\n"
      "border, and its normals there come from the cells inside the box. Adjacent boxes share no "
      "cell,\n"
      "so their parts together make the whole surface.\n"
      "\n" +
      examples("  isosplat extract engine.isosplat --isovalue 60.5 -o engine.ply\n"
               "  isosplat extract head.isosplat -i -300 --exact --level 1\n"
               "  isosplat extract engine.isosplat --isovalue 60.5 -o engine.npz\n"
               "  isosplat extract engine.isosplat --isovalue 60.5 --mesh -o engine.stl\n"
               "  isosplat extract engine.isosplat -i 60.5 --mesh --largest --simplify 0.1 -o "
               "part.3mf\n"
               "  isosplat extract engine.isosplat -i 60.5 --mesh --box 50,50,20,200,200,90 -o "
               "part.stl\n"
               "MeshLab, CloudCompare, Open3D and VTK read PLY files."));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
