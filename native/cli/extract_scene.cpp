#include "native/cli/extract_scene.h"

#include <fmt/format.h>
#include <isosplat/version.h>

#include <algorithm>
#include <set>

#include "native/cli/command.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/scene/layer_surfaces.h"
#include "shared/system/scene_file/scene_file.h"

namespace isosplat::cli {
namespace {

namespace fs = std::filesystem;

/// A surface of a layer.
struct Part {
  size_t layer = 0;
  double isovalue = 0;
  std::vector<FieldColumn> fields = {};  ///< those of --field that its store has
};

/// The surfaces of a scene at a step of time. Stores are opened once for the list, and once more
/// when their surface is extracted: a scene may have thousands.
class SceneExtraction {
 public:
  SceneExtraction(const SceneFile& scene, const ExtractCall& call)
      : file_(scene), call_(call), step_(call.step.value_or(first_step(scene.scene()))) {}

  Result<void> run();

 private:
  const Scene& scene() const { return file_.scene(); }
  Result<std::vector<size_t>> chosen_layers() const;
  Result<void> list_parts();
  std::vector<fs::path> paths(const fs::path& output, const MeshFormat& format) const;
  Result<void> check_outputs(std::span<const fs::path> outputs, const MeshFormat& format) const;
  Result<void> list_fields(size_t layer, const StoreFile& store, std::vector<FieldColumn>& fields);
  Result<void> order_fields();
  Result<void> append(size_t part, std::span<const FieldColumn> fields, MeshFile& file);
  Result<void> write_one(const fs::path& path, const MeshFormat& format);
  Result<void> write_each(std::span<const fs::path> outputs, const MeshFormat& format);
  std::string comment(const std::string& of_what) const;

  const SceneFile& file_;
  const ExtractCall& call_;
  const size_t step_;
  std::optional<SolidRequest> solid_;
  std::vector<Part> parts_;
  std::vector<MeshObject> objects_;  ///< of the parts
  std::vector<FieldColumn> fields_;  ///< of all parts, in the order of --field
  MeshCounts counts_;  ///< of what was written since they were reset; vertices: points
};

/// The layers with this name, or the one of this index.
std::vector<size_t> layers_named(const Scene& scene, const std::string& name) {
  std::vector<size_t> found;
  for (size_t i = 0; i < scene.layers.size(); ++i) {
    if (scene.layers[i].name == name) found.push_back(i);
  }
  for (size_t i = 0; found.empty() && i < scene.layers.size(); ++i) {
    if (std::to_string(i) == name) found.push_back(i);
  }
  return found;
}

Result<std::vector<size_t>> SceneExtraction::chosen_layers() const {
  std::set<size_t> chosen;
  for (const std::string& name : call_.layers) {
    const auto found = layers_named(scene(), name);
    if (found.empty()) {
      return fail(Status::not_found,
                  fmt::format("--layer: expected the name or the index of a layer, found '{}': "
                              "isosplat info lists the layers",
                              printable(name)));
    }
    chosen.insert(found.begin(), found.end());
  }
  for (size_t i = 0; call_.layers.empty() && i < scene().layers.size(); ++i) {
    if (scene().layers[i].visible) chosen.insert(i);
  }
  if (chosen.empty()) {
    return fail(Status::not_found, "expected a visible layer, found none: choose one with --layer");
  }
  return std::vector<size_t>(chosen.begin(), chosen.end());
}

Result<void> SceneExtraction::list_parts() {
  const auto layers = chosen_layers();
  if (!layers) return tl::unexpected(layers.error());
  for (const size_t i : *layers) {
    const SceneLayer& layer = scene().layers[i];
    const auto opened = open_layer(file_, i, step_);
    if (!opened) return tl::unexpected(opened.error());
    const auto number = static_cast<size_t>(
        std::count_if(scene().layers.begin(), scene().layers.begin() + static_cast<ptrdiff_t>(i),
                      [](const SceneLayer& before) { return before.visible; }));
    const auto surfaces = surfaces_of(layer, opened->store->info(), number);
    if (surfaces.empty()) note(no_surfaces(scene(), i));
    std::vector<FieldColumn> fields;
    if (auto listed = list_fields(i, *opened->store, fields); !listed) return listed;
    const std::string name = layer.name.empty() ? fmt::format("layer {}", i) : layer.name;
    for (const SceneSurface& surface : surfaces) {
      parts_.push_back({i, surface.isovalue, fields});
      objects_.push_back({surfaces.size() > 1 ? fmt::format("{} {}", name, surface.isovalue) : name,
                          *surface.colour, surface.opacity, opened->grid});
    }
  }
  if (!parts_.empty()) return order_fields();
  return fail(Status::not_found,
              "expected a surface, found none: add surfaces to the layers of the scene");
}

/// Appends the fields of --field that the store of a layer has, and notes those that it lacks.
Result<void> SceneExtraction::list_fields(size_t layer, const StoreFile& store,
                                          std::vector<FieldColumn>& fields) {
  std::vector<std::string> names;
  for (const std::string& name : call_.fields) {
    if (has_field(store.info(), name)) {
      names.push_back(name);
    } else {
      note(fmt::format("the store of {} has no field '{}'", name_of(scene(), layer), name));
    }
  }
  const auto opened = open_fields(store, names);
  if (!opened) return tl::unexpected(opened.error());
  fields = columns_of(*opened);
  for (const FieldColumn& field : fields) {
    const auto known = std::ranges::find(fields_, field.name, &FieldColumn::name);
    if (known == fields_.end()) fields_.push_back(field);
  }
  return {};
}

/// Brings fields_ into the order of --field. Errors: not_found, if no store has one of them.
Result<void> SceneExtraction::order_fields() {
  auto next = fields_.begin();
  for (const std::string& name : call_.fields) {
    const auto found = std::ranges::find(fields_, name, &FieldColumn::name);
    if (found != fields_.end()) {
      std::iter_swap(next++, found);
      continue;
    }
    return fail(
        Status::not_found,
        fmt::format("--field: expected a field of a store of the chosen layers, found '{}': "
                    "isosplat info lists the fields of a store",
                    printable(name)));
  }
  return {};
}

/// A name as a part of a file's name: letters, digits, "-", "_", "." and characters beyond ASCII.
std::string for_file(std::string_view name) {
  constexpr size_t kMaxBytes = 80;
  std::string text;
  for (const char c : name) {
    const bool stays = c < 0 || std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '.';
    text += stays ? c : '_';
  }
  if (text.size() <= kMaxBytes) return text;
  size_t end = kMaxBytes;  // not within a character of UTF-8
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end);
}

/// The output files: one, or one for each part.
std::vector<fs::path> SceneExtraction::paths(const fs::path& output,
                                             const MeshFormat& format) const {
  if (parts_.size() == 1 || (call_.mesh && format.has_objects)) return {output};
  std::vector<fs::path> paths;
  std::set<std::string> used;
  for (const MeshObject& object : objects_) {
    const std::string name = for_file(object.name);
    std::string unique = name;
    for (int i = 2; !used.insert(unique).second; ++i) unique = fmt::format("{}-{}", name, i);
    paths.push_back(output);
    paths.back().replace_filename(
        fmt::format("{}-{}{}", output.stem().string(), unique, output.extension().string()));
  }
  return paths;
}

Result<void> SceneExtraction::check_outputs(std::span<const fs::path> outputs,
                                            const MeshFormat& format) const {
  std::vector<fs::path> inputs{file_.path()};
  for (const std::string& store : store_paths(scene())) {
    inputs.push_back(file_.path().parent_path() / store);
  }
  for (const fs::path& output : outputs) {
    if (auto checked = check_not_input(output, inputs); !checked) return checked;
    auto checked = check_replaceable(output, format.beginning, format.name, call_.force);
    if (!checked) return checked;
  }
  return {};
}

Result<void> SceneExtraction::append(size_t i, std::span<const FieldColumn> fields,
                                     MeshFile& file) {
  const size_t layer = parts_[i].layer;
  const double isovalue = parts_[i].isovalue;
  const auto opened = open_layer(file_, layer, step_);
  if (!opened) return tl::unexpected(opened.error());
  const StoreFile& store = *opened->store;
  auto options = extract_options(call_, opened->grid);
  if (!options) return tl::unexpected(options.error());
  auto values = open_known_fields(store, fields);
  if (!values) return tl::unexpected(values.error());
  options->fields = std::move(*values);
  bool is_empty = false;
  if (call_.mesh) {
    const auto mesh = append_mesh(store, isovalue, *options, call_.changes, solid_, file);
    if (!mesh) return tl::unexpected(with_layer(scene(), layer, mesh.error()));
    explain_changes(*mesh, call_);
    is_empty = mesh->counts.triangles == 0;
    counts_.vertices += mesh->counts.vertices;
    counts_.triangles += mesh->counts.triangles;
  } else {
    const auto points = append_points(store, isovalue, call_.projection, *options, file);
    if (!points) return tl::unexpected(with_layer(scene(), layer, points.error()));
    is_empty = *points == 0;
    counts_.vertices += *points;
  }
  if (is_empty) {
    note(name_of(scene(), layer) + " is empty:");
    explain_no_surface(store.info(), isovalue, call_);
  }
  return {};
}

std::string SceneExtraction::comment(const std::string& of_what) const {
  return fmt::format("{} of {}, level {}, by isosplat " ISOSPLAT_VERSION, of_what,
                     file_.path().filename().string(), call_.level);
}

Result<void> SceneExtraction::write_one(const fs::path& path, const MeshFormat& format) {
  const auto file =
      format.create(path, {objects_[0].grid, parts_[0].isovalue, comment("isosurfaces"),
                           call_.content(), objects_, fields_});
  if (!file) return tl::unexpected(file.error());
  for (size_t i = 0; i < parts_.size(); ++i) {
    if (i > 0) {
      if (auto begun = (*file)->next_object(); !begun) return begun;
    }
    if (auto done = append(i, fields_, **file); !done) return done;
  }
  if (auto published = (*file)->publish(); !published) return published;
  fmt::print("{}: {} surfaces, {} triangles, {} vertices, {}\n", path.string(),
             with_commas(parts_.size()), with_commas(counts_.triangles),
             with_commas(counts_.vertices), format_bytes((*file)->bytes()));
  return {};
}

Result<void> SceneExtraction::write_each(std::span<const fs::path> outputs,
                                         const MeshFormat& format) {
  for (size_t i = 0; i < outputs.size(); ++i) {
    counts_ = {};
    const std::string what =
        fmt::format("isosurface {} of {}", parts_[i].isovalue, name_of(scene(), parts_[i].layer));
    const auto file = format.create(outputs[i], {objects_[i].grid,
                                                 parts_[i].isovalue,
                                                 comment(what),
                                                 call_.content(),
                                                 {},
                                                 parts_[i].fields});
    if (!file) return tl::unexpected(file.error());
    if (auto done = append(i, parts_[i].fields, **file); !done) return done;
    if (auto published = (*file)->publish(); !published) return published;
    const std::string count =
        call_.mesh ? fmt::format("{} triangles, {} vertices", with_commas(counts_.triangles),
                                 with_commas(counts_.vertices))
                   : with_commas(counts_.vertices) + " points with normals";
    fmt::print("{}: {}, {}\n", outputs[i].string(), count, format_bytes((*file)->bytes()));
  }
  return {};
}

Result<void> SceneExtraction::run() {
  if (auto exists = check_step(scene(), step_); !exists) return exists;
  const fs::path output = call_.output.empty()
                              ? file_.path().stem().string() + (call_.mesh ? ".glb" : ".ply")
                              : call_.output;
  const auto format = mesh_format(output, call_.content());
  if (!format) return tl::unexpected(format.error());
  if (!call_.fields.empty()) {
    auto holds = check_holds_fields(output, **format, call_.content());
    if (!holds) return holds;
  }
  auto solid = solid_request(call_, **format);
  if (!solid) return tl::unexpected(solid.error());
  solid_ = std::move(*solid);
  if (auto listed = list_parts(); !listed) return listed;
  const auto outputs = paths(output, **format);
  if (auto checked = check_outputs(outputs, **format); !checked) return checked;
  const bool in_one_file = call_.mesh && (*format)->has_objects;
  return in_one_file ? write_one(output, **format) : write_each(outputs, **format);
}

}  // namespace

int extract_scene(const ExtractCall& call) {
  const auto scene = open_scene(call.input, call.remote_flags);
  if (!scene) return report(scene.error());
  if (auto done = SceneExtraction(*scene, call).run(); !done) return report(done.error());
  return kSuccess;
}

}  // namespace isosplat::cli
