#include "native/cli/extract_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "native/cli/numbers.h"
#include "native/cli/options.h"
#include "native/cli/terminal.h"
#include "shared/core/scene/scene.h"

namespace isosplat::cli {
namespace {

constexpr int kMostClipPlanes = 64;

}  // namespace

void add_extract_options(CLI::App* command, ExtractCall* call) {
  command
      ->add_option("store", call->input,
                   "A store, a scene, a bundle, or an address of a store or a bundle; or an\n"
                   "unstructured or curvilinear grid of VTK, for points")
      ->required();
  command
      ->add_option("-i,--isovalue", call->isovalue,
                   "The isovalue, in the volume's values; a scene states\nthose of its layers")
      ->check(is_number());
  command->add_option("--dataset", call->dataset,
                      "Grids of VTK: the name of the array (default: the only one)");
  command
      ->add_option("--step", call->step,
                   "Scenes: index of the time step, from 0 (default: that which the scene shows "
                   "first)")
      ->check(is_whole_number(0, kMaxSteps - 1));
  command
      ->add_option("--layer", call->layers,
                   "Scenes: only the layer of this name or index; repeat the option for several\n"
                   "layers (default: all visible layers)")
      ->allow_extra_args(false);
  command
      ->add_option(
          "--field", call->fields,
          "Write the values of this field of the store at each point or vertex; repeat the\n"
          "option for several fields (isosplat info lists those of a store)")
      ->allow_extra_args(false);
  command->add_option(
      "-o,--output", call->output,
      "The file (default: STORE_ISOVALUE.ply in the current folder, or SCENE.glb for the\n"
      "triangles of a scene); its extension determines the format. Points: " +
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
          "X0,Y0,Z0,X1,Y1,Z1 in world units: extract only what is in this box; of points and open\n"
          "surfaces, the cells whose centres are in it")
      ->delimiter(',')
      ->check(is_number())
      ->expected(6);
  CLI::Option* mesh = command->add_flag("--mesh", call->mesh, "Write triangles instead of points");
  command
      ->add_flag_callback(
          "--closed", [call] { call->closed = true; },
          "Close the surface around the solid, where values are above the isovalue: at the\n"
          "volume's border, and at the faces of --box and --clip-plane, which cut exactly\n"
          "(default for STL and 3MF at level 0)")
      ->needs(mesh);
  command
      ->add_flag_callback(
          "--open", [call] { call->closed = false; },
          "Leave the surface open there; --box then keeps whole cells (default for PLY, OBJ,\n"
          "GLB and NPZ)")
      ->needs(mesh)
      ->excludes("--closed");
  command
      ->add_option("--clip-plane", call->clip_planes,
                   "X,Y,Z,OFFSET in world units: cut off a closed surface where the dot product\n"
                   "of a point with the normal X,Y,Z is below OFFSET; may be given several times")
      ->delimiter(',')
      ->check(is_number())
      ->expected(1, kMostClipPlanes)
      ->needs(mesh);
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
  call->remote_flags.add_to(*command);
  command->add_option("--threads", call->threads, "Number of threads (0: one per core)")
      ->check(is_whole_number(0, kMaxThreads))
      ->capture_default_str();
}

Result<ExtractOptions> extract_options(const ExtractCall& call, const VolumeGrid& grid) {
  ExtractOptions options{call.level, call.threads, call.shading == "smooth"};
  options.grid = grid;
  if (call.box.empty()) return options;
  const Vec3d low{call.box[0], call.box[1], call.box[2]};
  const Vec3d high{call.box[3], call.box[4], call.box[5]};
  if (low.x < high.x && low.y < high.y && low.z < high.z) {
    options.region = CellRegion::in_world(grid, low, high);
    return options;
  }
  return fail(Status::invalid_argument,
              fmt::format("expected --box X0,Y0,Z0,X1,Y1,Z1 with X0 < X1, Y0 < Y1 and Z0 < Z1, "
                          "found {}: swap the coordinates that are in the wrong order",
                          fmt::join(call.box, ",")));
}

Result<std::optional<SolidRequest>> solid_request(const ExtractCall& call,
                                                  const MeshFormat& format) {
  if (!call.mesh || !call.closed.value_or(format.is_solid && call.level == 0)) {
    if (call.clip_planes.empty()) return std::optional<SolidRequest>{};
    return fail(Status::invalid_argument,
                "--clip-plane: expected a closed surface, found an open one: add --closed");
  }
  SolidRequest request{.cuts = {},
                       .is_required = call.closed.has_value() || !call.clip_planes.empty()};
  if (!call.box.empty()) {
    request.cuts.box = {
        {{call.box[0], call.box[1], call.box[2]}, {call.box[3], call.box[4], call.box[5]}}};
  }
  for (const auto& [x, y, z, offset] : call.clip_planes) {
    if (x == 0 && y == 0 && z == 0) {
      return fail(Status::invalid_argument,
                  "--clip-plane: expected X,Y,Z,OFFSET with a normal X,Y,Z other than 0,0,0, found "
                  "the normal 0,0,0");
    }
    request.cuts.planes.push_back({{x, y, z}, offset});
  }
  return std::optional(std::move(request));
}

void explain_no_surface(const StoreInfo& info, double isovalue, const ExtractCall& call) {
  const std::string reason = no_isosurface(info, isovalue);
  note(!reason.empty() ? reason
       : !call.box.empty()
           ? fmt::format("no cell of level {} in --box is active at {}: isosplat info prints the "
                         "volume's origin and spacing in world units",
                         call.level, isovalue)
           : fmt::format("no cell of level {} is active at {}: all cells that the isosurface would "
                         "cross touch missing voxels",
                         call.level, isovalue));
}

void explain_changes(const WrittenMesh& mesh, const ExtractCall& call) {
  if (mesh.is_left_open) {
    note("the surface is open: missing voxels leave holes in it, and --box keeps whole cells");
  }
  if (mesh.components_found) {
    note(fmt::format("kept {} of {} components",
                     with_commas(std::min(*call.changes.components, *mesh.components_found)),
                     with_commas(*mesh.components_found)));
  }
  if (mesh.simplified_within) {
    note(fmt::format("simplified; the largest quadric error (root mean square) is {:.4g}",
                     *mesh.simplified_within));
  }
}

}  // namespace isosplat::cli
