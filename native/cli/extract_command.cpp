#include <fmt/format.h>
#include <isosplat/version.h>

#include <array>

#include "native/cli/command.h"
#include "native/cli/extract_cells.h"
#include "native/cli/extract_options.h"
#include "native/cli/extract_scene.h"
#include "native/cli/grid_kind.h"
#include "native/cli/options.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "shared/system/scene_file/scene_file.h"

namespace isosplat::cli {
namespace {

int run(const ExtractCall& call) {
  const auto store = open_store(call.input, call.remote_flags);
  if (!store) return report(store.error());
  const StoreInfo& info = (*store)->info();
  const double isovalue = *call.isovalue;
  const std::filesystem::path path =
      call.output.empty() ? (*store)->path().stem().string() + fmt::format("_{}.ply", isovalue)
                          : call.output;
  if (auto checked = check_not_input(path, std::array<std::filesystem::path, 1>{call.input});
      !checked) {
    return report(checked.error());
  }
  const auto format = mesh_format(path, call.content());
  if (!format) return report(format.error());
  if (!call.fields.empty()) {
    const auto holds = check_holds_fields(path, **format, call.content());
    if (!holds) return report(holds.error());
  }
  const auto replaceable =
      check_replaceable(path, (*format)->beginning, (*format)->name, call.force);
  if (!replaceable) return report(replaceable.error());
  auto options = extract_options(call, info.grid);
  if (!options) return report(options.error());
  const auto solid = solid_request(call, **format);
  if (!solid) return report(solid.error());
  options->threads = threads_for(call.input, options->threads);
  const std::string comment =
      fmt::format("isosurface {} of {}, level {}, by isosplat " ISOSPLAT_VERSION, isovalue,
                  (*store)->path().filename().string(), call.level);
  auto fields = open_fields(**store, call.fields);
  if (!fields) return report(fields.error());
  options->fields = std::move(*fields);
  const std::vector<FieldColumn> columns = columns_of(options->fields);
  const auto file =
      (*format)->create(path, {info.grid, isovalue, comment, call.content(), {}, columns});
  if (!file) return report(file.error());
  if (call.mesh) {
    const auto mesh = append_mesh(**store, isovalue, *options, call.changes, *solid, **file);
    if (!mesh) return report(mesh.error());
    if (auto published = (*file)->publish(); !published) return report(published.error());
    explain_changes(*mesh, call);
    fmt::print("{}: {} triangles, {} vertices, {}\n", path.string(),
               with_commas(mesh->counts.triangles), with_commas(mesh->counts.vertices),
               format_bytes((*file)->bytes()));
    if (mesh->counts.triangles == 0) explain_no_surface(info, isovalue, call);
    return kSuccess;
  }
  const auto points = append_points(**store, isovalue, call.projection, *options, **file);
  if (!points) return report(points.error());
  if (auto published = (*file)->publish(); !published) return report(published.error());
  fmt::print("{}: {} points with normals, {}\n", path.string(), with_commas(*points),
             format_bytes((*file)->bytes()));
  if (*points == 0) explain_no_surface(info, isovalue, call);
  return kSuccess;
}

/// Checks that the options fit a store or a scene. Throws the errors of CLI11 for wrong arguments.
void check_arguments(const ExtractCall& call, bool is_scene) {
  if (!is_scene && !call.isovalue) throw CLI::RequiredError("--isovalue");
  if (!is_scene && !call.layers.empty()) throw CLI::ExcludesError("a store", "--layer");
  if (is_scene && call.isovalue) {
    throw CLI::ExcludesError("a scene, which states its surfaces,", "--isovalue");
  }
}

}  // namespace

void add_extract_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand(
      "extract", "Write isosurfaces of a store or a scene as points with normals, or as triangles");
  auto call = std::make_shared<ExtractCall>();
  add_extract_options(command, call.get());
  command->footer(
      "Without --mesh, the file has one point for each active cell: the cell's centre, moved onto\n"
      "the surface by one Newton step, but not out of the cell. On noisy volumes --drop-displaced\n"
      "omits about an eighth of the points, which leaves holes.\n"
      "With --mesh, triangles are counter-clockwise seen from the side of smaller values. In PLY,\n"
      "OBJ and GLB files they share vertices, which have smooth normals; STL has a normal for "
      "each\n"
      "triangle, and 3MF has none. Positions are in world space. Its unit is taken to\n"
      "be the millimetre: STL files, which state no unit, and 3MF files have millimetres, as "
      "programs for\n"
      "printing expect; GLB positions are converted to metres, with y up. PLY files "
      "store\n"
      "positions in double precision if single precision would be wrong by more than 1/2000 of a "
      "voxel.\n"
      "NumPy loads .npy and .npz: an .npy file has one array of points with the fields position,\n"
      "normal and value. An .npz file has the arrays positions, normals and isovalue, and with "
      "--mesh the\n"
      "array triangles.\n"
      "With --field, a point has the value of the field's trilinear function in its cell, and so "
      "has a\n"
      "vertex of a mesh: on an edge of cells, the value between the ends of this edge. At level 0, "
      "the\n"
      "values are within the error that isosplat info states, and are rounded to single "
      "precision.\n"
      "PLY has a property, NumPy and VTP an array, of the field's name; missing values are NaN. "
      "GLB\n"
      "has an attribute, _PRESSURE for pressure, with -3.4028235e38 for missing values, and "
      "colours\n"
      "(viridis) that show the first field from its 1st to its 99th percentile. The other formats\n"
      "have no values. Where a closed surface is cut, the outline of the cut has values, and "
      "points\n"
      "inside of it have none.\n"
      "A closed surface (--closed, and STL and 3MF files of level 0 unless --open is given) "
      "encloses the "
      "solid: where\n"
      "values are above the isovalue. It ends at the volume's outermost voxels, and is in memory "
      "as a whole,\n"
      "some 150 bytes for each vertex. If missing voxels leave holes in it, it stays open, or "
      "with --closed\n"
      "is refused. An open surface with --box ends at faces of cells, and its normals there come "
      "from the\n"
      "cells inside the box. Adjacent boxes share no cell, so their parts together make the whole "
      "surface.\n"
      "For a scene, each surface of each layer is extracted, at its position in the scene. GLB,\n"
      "3MF and OBJ files hold all of them, with their names, and GLB and 3MF with their colours.\n"
      "In the other formats, each surface becomes a separate file: OUTPUT-LAYER.ply. The scene's\n"
      "clipping is not applied.\n"
      "Of an unstructured or curvilinear grid (.vtu, .vts …), points are written without a store: "
      "one for\n"
      "each active cell of the mesh, on the surface of its shape functions, with the normal, the "
      "size\n"
      "of the cell, and the values of other arrays (--field).\n"
      "\n" +
      examples(
          "  isosplat extract engine.isosplat --isovalue 60.5 -o engine.ply\n"
          "  isosplat extract head.isosplat -i -300 --exact --level 1\n"
          "  isosplat extract engine.isosplat --isovalue 60.5 -o engine.npz\n"
          "  isosplat extract flow.isosplat -i 0.5 --mesh --field pressure -o flow.ply\n"
          "  isosplat extract engine.isosplat --isovalue 60.5 --mesh -o engine.stl\n"
          "  isosplat extract engine.isosplat -i 60.5 --mesh --largest --simplify 0.1 -o "
          "part.3mf\n"
          "  isosplat extract engine.isosplat -i 60.5 --mesh --box 50,50,20,200,200,90 -o "
          "part.stl\n"
          "  isosplat extract engine.isosplat -i 60.5 --mesh --clip-plane 1,1,0,180 -o half.stl\n"
          "  isosplat extract head.isobundle --mesh --level 1 -o head.glb\n"
          "  isosplat extract https://example.org/stores/engine.isosplat -i 60.5 -o engine.ply\n"
          "  isosplat extract flow.vtu --dataset pressure -i 1.5 --field speed -o flow.vtp\n"
          "  isosplat extract scene.json --mesh --layer skull -o skull.stl\n"
          "MeshLab, CloudCompare, Open3D and VTK read PLY files; ParaView and VTK read VTP "
          "files."));
  command->callback([call, &exit_code] {
    const bool is_scene = scene_kind(call->input, call->remote_flags) != SceneKind::none;
    check_arguments(*call, is_scene);
    if (!is_scene && grid_kind(call->input) == GridKind::unstructured) {
      exit_code = extract_cells(*call);
      return;
    }
    if (!call->dataset.empty()) throw CLI::ExcludesError("a store or a scene", "--dataset");
    exit_code = is_scene ? extract_scene(*call) : run(*call);
  });
}

}  // namespace isosplat::cli
