#include <fmt/format.h>

#include <algorithm>

#include "native/builder/source_path.h"
#include "native/cli/adaptive_building.h"
#include "native/cli/bucket_output.h"
#include "native/cli/building.h"
#include "native/cli/command.h"
#include "native/cli/field_inputs.h"
#include "native/cli/label_building.h"
#include "native/cli/options.h"
#include "native/cli/outputs.h"
#include "native/cli/scene_building.h"
#include "native/cli/store_building.h"
#include "native/cli/terminal.h"
#include "native/cli/thumbnail.h"
#include "native/remote/remote_target.h"
#include "native/scene/scene_output.h"
#include "shared/core/scene/bundle_header.h"

namespace isosplat::cli {
namespace {

struct BuildCall : StoreFlags {
  std::vector<std::string> volumes, fields;
  std::string steps, time_unit, labels, label_table, part;
  std::string source_path_hash;  // see StoreCall
  bool has_labels = false, resumes = false;
  RemoteFlags remote_flags;
};

bool is_folder(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_directory(path, ignored);
}

Result<SceneInputs> scene_inputs(const BuildCall& call, const import::ImportOptions& options) {
  if (!call.steps.empty()) return listed_steps(call.steps, options);
  if (call.volumes.size() == 1) return volumes_of_file(call.volumes.front(), options);
  return files_as_steps({call.volumes.begin(), call.volumes.end()}, options);
}

SceneBuildOptions scene_options(const BuildCall& call, const std::filesystem::path& output,
                                const BuildOptions& build_options) {
  SceneBuildOptions options;
  options.build = build_options;
  options.key = call.volume_flags.key() + '\n' + call.build_flags.key();
  options.name = build_options.title.empty()
                     ? (output.has_filename() ? output : output.parent_path()).stem().string()
                     : build_options.title;
  options.time_unit = call.time_unit;
  options.force = call.force;
  return options;
}

std::string kept_text(const SceneReport& built) {
  return built.kept > 0 ? fmt::format(" ({} stores were complete before)", built.kept) : "";
}

/// "1 layer", "3 layers".
std::string counted(uint64_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// Prints what was built and the command that shows it, and draws the scene's picture. `contents`:
/// "3 labels". Returns kSuccess.
int finish_scene(const BuildCall& call, const std::filesystem::path& output,
                 const SceneReport& built, const std::string& contents) {
  if (!call.quiet) {
    fmt::print("{}: {}, {}, built in {}{}\n", output.string(), contents, format_bytes(built.bytes),
               format_seconds(built.seconds), kept_text(built));
    fmt::print("isosplat view {} shows it\n", output.string());
  }
  if (call.no_thumbnail) return kSuccess;
  // The scene is complete, and can be served without a picture.
  const auto scene = output.extension() == ".isobundle" ? output : output / kSceneName;
  if (auto drawn = draw_scene_thumbnail(scene); !drawn) {
    note("no thumbnail: " + drawn.error().message);
  }
  return kSuccess;
}

/// Builds several stores and their scene.
int run_scene(const BuildCall& call, const import::ImportOptions& import_options,
              const BuildOptions& build_options) {
  const std::filesystem::path output = call.store;
  if (output.extension() == ".isobundle") {
    if (auto checked = check_replaceable_bundle(output, call.force); !checked) {
      return report(checked.error());
    }
  }
  const auto inputs = scene_inputs(call, import_options);
  if (!inputs) return report(inputs.error());
  for (const std::string& text : inputs->notes) note(text);
  SceneBuildOptions options = scene_options(call, output, build_options);
  if (auto fields = field_files_of_steps(call.fields, import_options, *inputs)) {
    options.fields = std::move(*fields);
  } else {
    return report(fields.error());
  }
  const auto built = build_scene(*inputs, output, options);
  if (!built) return report(built.error());
  return finish_scene(call, output, *built,
                      counted(built->layers, "layer") + ", " + counted(built->steps, "time step"));
}

/// The output of a build whose result is always a scene: the bundle beside the volume, unless -o
/// names another bundle or a folder. `what`: the input, for messages. Errors: invalid_argument.
Result<std::filesystem::path> scene_output(const BuildCall& call, std::string_view what) {
  std::filesystem::path output = call.store;
  if (output.empty()) {
    output = default_store(call.volumes.front()).replace_extension();
    output += ".isobundle";
  }
  if (!SceneOutput::is_scene(output) && !is_folder(output)) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected a bundle (-o NAME.isobundle) or a folder (-o NAME/) for "
                            "several layers, found '{}'",
                            what, output.string()));
  }
  if (output.extension() == ".isobundle") {
    if (auto checked = check_replaceable_bundle(output, call.force); !checked) {
      return tl::unexpected(checked.error());
    }
  }
  return output;
}

/// Builds a scene with a layer for each label of a volume.
int run_labels(const BuildCall& call, const import::ImportOptions& import_options,
               const BuildOptions& build_options) {
  if (call.volumes.size() != 1) {
    return report(
        {Status::invalid_argument,
         fmt::format("--labels: expected one volume of labels, found {}", call.volumes.size())});
  }
  if (build_options.range) {
    return report({Status::invalid_argument, "expected --labels or --range, found both"});
  }
  const auto output = scene_output(call, "--labels");
  if (!output) return report(output.error());
  LabelBuildOptions options;
  options.scene = scene_options(call, *output, build_options);
  options.import = import_options;
  options.surface = call.labels == "raw" ? LabelSurface::raw : LabelSurface::smooth;
  if (!call.label_table.empty()) {
    auto table = read_label_table(call.label_table);
    if (!table) return report(table.error());
    options.table = std::move(*table);
  }
  auto fields = field_files(call.fields, import_options);
  if (!fields) return report(fields.error());
  options.fields = std::move(*fields);
  const auto built = build_labels(call.volumes.front(), *output, options);
  if (!built) return report(built.error());
  return finish_scene(call, *output, *built, counted(built->layers, "label"));
}

/// Builds a scene with a layer for each refinement level of an adaptive or unstructured grid.
int run_adaptive(const BuildCall& call, GridKind kind, const import::ImportOptions& import_options,
                 const BuildOptions& build_options) {
  const auto output = scene_output(call, "an adaptive or unstructured grid");
  if (!output) return report(output.error());
  auto fields = field_files(call.fields, import_options);
  if (!fields) return report(fields.error());
  const auto built = build_adaptive(
      call.volumes.front(), *output,
      {kind, scene_options(call, *output, build_options), import_options, std::move(*fields)});
  if (!built) return report(built.error());
  return finish_scene(call, *output, *built, counted(built->layers, "refinement level"));
}

/// The builder of a store with the fields that the call names.
StoreBuilder builder_with_fields(const BuildCall& call, const import::ImportOptions& options) {
  return [texts = call.fields, volume = call.volumes.front(), options](
             VolumeSource& source, const std::filesystem::path& target,
             const BuildOptions& build) -> Result<BuildReport> {
    const auto files = field_files(texts, options, volume);
    if (!files) return tl::unexpected(files.error());
    const VolumeGrid& grid = source.header().grid;
    const auto fields = place_fields(*files, grid, {.target = target}, note);
    if (!fields) return tl::unexpected(fields.error());
    return build_store_with_fields(source, field_inputs(*fields, grid), target, build);
  };
}

/// Builds what the options state. `call.store`: a path.
int build_locally(BuildCall& call) {
  // As in "--labels seg.nii.gz", since the kind of surface is optional.
  if (call.has_labels && !call.labels.empty() && call.labels != "raw" && call.labels != "smooth") {
    call.volumes.insert(call.volumes.begin(), std::exchange(call.labels, {}));
  }
  auto store = call.store_call();
  if (!store) return report(store.error());
  const bool has_steps = call.volumes.size() != 1;
  const GridKind kind = has_steps ? GridKind::regular : grid_kind(call.volumes.front());
  const bool is_adaptive_grid = kind != GridKind::regular;
  const bool is_scene = !call.store.empty() &&
                        (SceneOutput::is_scene(call.store) || (has_steps && is_folder(call.store)));
  if (call.volumes.empty() == call.steps.empty()) {
    return report({Status::invalid_argument, "expected volumes, or a list of them after --steps"});
  }
  if ((call.has_labels || is_scene || has_steps || is_adaptive_grid) &&
      (call.resumes || !call.part.empty())) {
    return report({Status::invalid_argument,
                   fmt::format("{}: expected one volume and a store, found a scene{}",
                               call.resumes ? "--resume" : "--part",
                               call.resumes ? ", which continues without it" : "")});
  }
  if (!call.fields.empty() && (call.resumes || !call.part.empty())) {
    return report({Status::invalid_argument,
                   "--field: expected a volume that is built at once, found --resume or --part"});
  }
  if (has_steps) {
    const auto grid = std::ranges::find_if(
        call.volumes, [](const auto& v) { return grid_kind(v) != GridKind::regular; });
    if (grid != call.volumes.end()) {
      return report({Status::invalid_argument,
                     fmt::format("{}: expected one adaptive or unstructured grid, found {} files: "
                                 "build a scene of each of them",
                                 *grid, call.volumes.size())});
    }
  }
  if (call.has_labels) return run_labels(call, store->import, store->build);
  if (is_adaptive_grid) return run_adaptive(call, kind, store->import, store->build);
  if (is_scene) return run_scene(call, store->import, store->build);
  if (has_steps) {
    return report({Status::invalid_argument,
                   "expected one volume for a store, found several steps: name a bundle with -o "
                   "NAME.isobundle, or a folder with -o NAME/"});
  }
  store->volume = call.volumes.front();
  store->source_path_hash = call.source_path_hash;
  store->resumes = call.resumes;
  if (!call.fields.empty()) store->builder = builder_with_fields(call, store->import);
  if (!call.part.empty()) {
    store->part = parse_part(call.part);
    if (!store->part) {
      return report({Status::invalid_argument,
                     fmt::format("--part: expected a part such as 3/16, found '{}'", call.part)});
    }
  }
  return build_one_store(std::move(*store));
}

/// Builds to a temporary folder, and uploads the output.
int build_in_bucket(BuildCall& call) {
  const std::string address = call.store;
  if (call.resumes || !call.part.empty()) {
    return report({Status::invalid_argument,
                   fmt::format("{}: expected a store in a folder, found {}: build it to a file",
                               call.resumes ? "--resume" : "--part", address)});
  }
  const auto options = call.build_flags.options();
  if (!options) return report(options.error());
  auto output = BucketOutput::create(address, call.remote_flags, options->temporary_folder);
  if (!output) return report(output.error());
  // A bucket has no folder to which the path could be relative.
  if (call.volumes.size() == 1) {
    call.source_path_hash = source_path_hash(call.volumes.front(), std::filesystem::path("/store"));
  }
  if (!call.force) {
    auto checked = output->check_replaceable(call.source_path_hash);
    if (!checked) return report(checked.error());
  }
  const bool quiet = std::exchange(call.quiet, true);  // its result would name the temporary folder
  call.store = output->file().string();
  if (const int code = build_locally(call); code != kSuccess) return code;
  const auto bytes = output->publish(call.force);
  if (!bytes) return report(bytes.error());
  if (!quiet) fmt::print("{}: {}, built and uploaded\n", address, format_bytes(*bytes));
  return kSuccess;
}

int run(BuildCall& call) {
  if (call.quiet) set_quiet();
  if (remote::is_bucket_address(call.store)) return build_in_bucket(call);
  if (remote::is_address(call.store)) {
    return report({Status::invalid_argument,
                   "-o: expected a file or s3://BUCKET/KEY, found an address that cannot be "
                   "written to"});
  }
  return build_locally(call);
}

}  // namespace

void add_build_command(CLI::App& program, int& exit_code) {
  CLI::App* command = program.add_subcommand("build", "Build a store from a volume");
  auto call = std::make_shared<BuildCall>();
  command->add_option(
      "volume", call->volumes,
      "NRRD, MetaImage, NIfTI, MGH, MRC, NumPy, HDF5, netCDF, VTK, TIFF, cube, VASP, XSF, "
      "OpenDX or raw file, an adaptive, unstructured or curvilinear grid of VTK "
      "(.vthb, .vtu, .vts), or a folder of DICOM or TIFF slices; several are the time steps of a "
      "scene");
  command->add_option(
      "-o,--output", call->store,
      "The store to write (default: NAME.isosplat in the folder of the volume NAME), or a scene: "
      "NAME.isobundle, or a folder NAME/. s3://BUCKET/KEY uploads the store or bundle, which is "
      "built in --temporary-folder first");
  command->add_option("--steps", call->steps,
                      "List of the time steps of a scene: a text file with a time, a blank and a "
                      "path in each line");
  command->add_option("--time-unit", call->time_unit,
                      "Unit of the times of a scene, such as s (default: that of the file)");
  command
      ->add_option_function<std::string>(
          "--labels",
          [call](const std::string& kind) {
            call->has_labels = true;
            call->labels = kind;
          },
          "A scene with a smooth surface for each label or segment of a segmentation; raw: "
          "with the stairs of its voxels")
      ->expected(0, 1)
      ->type_name("[raw]");
  command->add_option("--label-table", call->label_table,
                      "Names and colours of labels: CSV (value,name,r,g,b,a), ITK-SNAP, FreeSurfer "
                      "or Workbench's XML (default: those in the volume's file)");
  command
      ->add_option("--field", call->fields,
                   "A second volume, which the store holds where its surfaces are, such as "
                   "temperature=t.nrrd. On other voxels, it is resampled. NAME=FILE#DATASET names "
                   "a dataset of HDF5 or an array of .npz. For time steps: NAME=PATTERN with *, a "
                   "list as for --steps (.txt), a file with time steps, or one volume for all "
                   "steps. NAME=@gradient is the magnitude of the volume's gradient, and "
                   "NAME=@curvature the mean curvature of its isosurfaces. "
                   "NAME=@distance(FILE) is the distance from the labels of a volume, negative "
                   "inside; @distance(FILE,3,5): from the labels 3 and 5. "
                   "NAME=@labels(FILE) is a volume of labels, each of which gets a colour of its "
                   "own; @labels(FILE,TABLE): with a table as for --label-table. The option can be "
                   "repeated")
      ->type_name("NAME=FILE")
      ->allow_extra_args(false);
  CLI::Option* part =
      command
          ->add_option("--part", call->part,
                       "Build one of N parts of the store, on this or another machine, to the file "
                       "STORE.part-I-of-N; isosplat join makes the store of them")
          ->type_name("I/N");
  command
      ->add_flag("--resume", call->resumes,
                 "Keep finished blocks in the file STORE.unfinished until the store is complete. "
                 "After an interruption, the same command continues with them")
      ->excludes(part);
  call->add_to(*command);
  call->remote_flags.add_to(*command);
  command->footer(examples(
      "  isosplat build head.nii.gz\n"
      "  isosplat build scans/ct -o ct.isosplat --units HU\n"
      "  isosplat build foot.raw --dims 256x256x256 --type u8 --spacing 1,1,1.5\n"
      "  isosplat build huge.nrrd --memory 4G --threads 8\n"
      "  isosplat build step_*.nrrd -o run.isobundle --time-unit s\n"
      "  isosplat build cells.tif -o cells.isobundle\n"
      "  isosplat build organs.nii.gz --labels\n"
      "  isosplat build blast.vthb\n"
      "  isosplat build flow.vtu --dataset pressure --max-error 0.01\n"
      "  isosplat build density.nrrd --field temperature=temperature.nrrd\n"
      "  isosplat build head.nii.gz -o s3://bucket/head.isosplat\n"
      "  isosplat build huge.nrrd --resume\n"
      "  isosplat build huge.nrrd --part 3/16     then, when all are built: isosplat join "
      "huge.nrrd\n"
      "A scene has a layer for each channel and a store for each time step. The steps of a layer\n"
      "have the same quantized values. Call an interrupted build again to continue it. A later\n"
      "call can add steps to a folder.\n"
      "An unstructured, curvilinear or unevenly spaced grid (.vtu, .vts, .vtr) is resampled to "
      "cells\n"
      "that are no larger than its own.\n"
      "For it, --max-error limits the difference between both (default: 0.5 % of the range).\n"
      "The output appears under its name only when it is complete. It replaces an older store of\n"
      "the same volume, but never an input file.\n"
      "\n"
      "This table shows the effect of --max-error on three floating-point volumes (head atlas,\n"
      "hydrogen atom, viscous fingers): the size of the store, and the bytes fetched for one\n"
      "isovalue. Both are relative to the default, whose error is at most 0.0008 % of the range "
      "of\n"
      "values.\n"
      "                        store               isovalue\n"
      "  0.01 % of the range   0.70  0.59  0.63    0.71  0.65  0.66\n"
      "  0.1 %                 0.47  0.32  0.34    0.46  0.34  0.36\n"
      "  0.4 % (8 bits)        0.33  0.22  0.23    0.31  0.22  0.21\n"
      "\n"
      "With --fetch-weight W, the store is at most √W times as large as the voxels, unless the\n"
      "volume is mostly noise. This table shows, for each W, the size of the store divided by the\n"
      "size of the voxels, and how the bytes fetched for an isovalue (all levels) differ from "
      "those\n"
      "with W = 1:\n"
      "  W                     1/4          1/2      1            2            4\n"
      "  engine, CT     0.49 +32 %   0.58  +8 %   0.68   0.84  -7 %   1.06 -11 %\n"
      "  head, noisy MR 0.49 +76 %   0.69 +13 %   0.98   1.38 -10 %   1.96 -16 %\n"
      "  aneurysm       0.12  +8 %   0.16  +3 %   0.21   0.28  -3 %   0.39  -4 %"));
  command->callback([call, &exit_code] { exit_code = run(*call); });
}

}  // namespace isosplat::cli
