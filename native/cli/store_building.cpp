#include "native/cli/store_building.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "native/builder/kept_blocks.h"
#include "native/builder/source_path.h"
#include "native/cli/command.h"
#include "native/cli/input_version.h"
#include "native/cli/numbers.h"
#include "native/cli/outputs.h"
#include "native/cli/terminal.h"
#include "native/cli/thumbnail.h"
#include "native/labels/looks_like_labels.h"

namespace isosplat::cli {
namespace {

void print_result(const std::filesystem::path& store, const BuildReport& built) {
  const StoreInfo& info = built.info;
  const Index3 n = info.grid.voxels;
  const double voxels = static_cast<double>(n.x) * n.y * n.z;
  fmt::print(
      "{}: {} × {} × {} voxels, {} ({:.2f} × the voxels), {} chunks, built in {} "
      "({:.0f} million voxels/s)\n",
      store.string(), n.x, n.y, n.z, format_bytes(info.file_bytes),
      static_cast<double>(info.file_bytes) / static_cast<double>(built.raw_bytes),
      with_commas(info.chunk_count), format_seconds(built.seconds),
      voxels / std::max(built.seconds, 1e-9) / 1e6);
  uint64_t field_bytes = 0;
  for (const FieldRef& field : info.fields) {
    field_bytes += field.bytes;
    fmt::print("Field {}: {}, {}\n", field.info.name, format_bytes(field.bytes),
               field.info.mapping.max_error == 0
                   ? std::string("lossless")
                   : fmt::format("values are within ±{:.3g}", field.info.mapping.max_error));
  }
  if (info.file_bytes - field_bytes > built.max_bytes) {
    fmt::print(
        "The store exceeds the size limit of {}: the volume is very small, or mostly noise, which "
        "hardly compresses\n",
        format_bytes(built.max_bytes));
  }
  if (info.missing_voxels > 0) {
    fmt::print("{} voxels are missing, infinite or not a number: cells that touch them are empty\n",
               with_commas(info.missing_voxels));
  }
}

/// The files of parts of a store, in ascending order of their names.
std::vector<std::filesystem::path> find_parts(const std::filesystem::path& store) {
  const std::string prefix = store.filename().string() + ".part-";
  std::vector<std::filesystem::path> parts;
  std::error_code ignored;
  const auto folder = store.has_parent_path() ? store.parent_path() : std::filesystem::path(".");
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (entry.path().filename().string().starts_with(prefix)) parts.push_back(entry.path());
  }
  std::sort(parts.begin(), parts.end());
  return parts;
}

int build_part(const StoreCall& call, const import::OpenVolume& volume) {
  const std::filesystem::path path = part_path(call.store, *call.part);
  if (auto replaceable = check_replaceable(path, "\x89ISOP", "a part of a store", call.force);
      !replaceable) {
    return report(replaceable.error());
  }
  const auto built = build_part_with_progress(volume, path, call.build, *call.part);
  if (!built) return report(built.error());
  if (!call.quiet) {
    std::error_code ignored;
    fmt::print("{}: {} of {} blocks, {}, built in {}\n", path.string(), with_commas(built->blocks),
               with_commas(built->all_blocks),
               format_bytes(std::filesystem::file_size(path, ignored)),
               format_seconds(built->seconds));
  }
  return kSuccess;
}

/// The encoded blocks that the build takes; null if there are none.
Result<std::unique_ptr<KeptBlocks>> kept_blocks(const StoreCall& call,
                                                const std::vector<std::filesystem::path>& parts) {
  if (call.resumes) return KeptBlocks::of_interrupted(unfinished_path(call.store));
  if (!call.joins) return nullptr;
  if (parts.empty()) {
    return fail(Status::invalid_argument,
                fmt::format("expected parts of the store, such as {}, found none: isosplat build "
                            "VOLUME --part 1/2 builds one",
                            part_path(call.store, {1, 2}).string()));
  }
  return KeptBlocks::of_parts(parts);
}

}  // namespace

void StoreFlags::add_to(CLI::App& command) {
  command.add_flag("-q,--quiet", quiet, "Print nothing on success");
  command.add_flag("--force", force,
                   "Replace the output file even if it is a store of another volume, or no store");
  command
      .add_flag(
          "--no-thumbnail", no_thumbnail,
          "Do not draw the thumbnail, STORE.webp beside the store, which lists of volumes show")
      ->envname("ISOSPLAT_NO_THUMBNAIL");
  build_flags.add_to(command);
  volume_flags.add_to(command);
}

Result<StoreCall> StoreFlags::store_call() const {
  const auto import_options = volume_flags.options();
  if (!import_options) return tl::unexpected(import_options.error());
  const auto build_options = build_flags.options();
  if (!build_options) return tl::unexpected(build_options.error());
  StoreCall call;
  call.store = store;
  call.import = *import_options;
  call.import.memory_bytes = build_options->memory_bytes;
  call.build = *build_options;
  call.volume_key = volume_flags.key();
  call.quiet = quiet;
  call.force = force;
  call.no_thumbnail = no_thumbnail;
  return call;
}

std::filesystem::path default_store(const std::filesystem::path& volume) {
  const auto path = volume.has_filename() ? volume : volume.parent_path();
  return path.parent_path() / (store_stem(volume) + ".isosplat");
}

std::filesystem::path part_path(const std::filesystem::path& store, Part part) {
  return store.string() + fmt::format(".part-{}-of-{}", part.number, part.count);
}

std::filesystem::path unfinished_path(const std::filesystem::path& store) {
  return store.string() + ".unfinished";
}

std::optional<Part> parse_part(std::string_view text) {
  const size_t slash = text.find('/');
  if (slash == text.npos) return std::nullopt;
  const auto number = parse_whole_number(text.substr(0, slash));
  const auto count = parse_whole_number(text.substr(slash + 1));
  if (!number || !count || *number < 1 || *number > *count || *count > kMaxParts) {
    return std::nullopt;
  }
  return Part{static_cast<uint32_t>(*number), static_cast<uint32_t>(*count)};
}

int build_one_store(StoreCall call) {
  if (call.store.empty()) call.store = default_store(call.volume);
  const std::filesystem::path& store = call.store;
  const auto opened = import::open_volume(call.volume, call.import);
  if (!opened) return report(opened.error());
  const auto files = opened->source->files();
  for (const auto& output : {store, unfinished_path(store)}) {
    if (auto other = check_not_input(output, files); !other) return report(other.error());
  }
  BuildOptions& options = call.build;
  options.source_file = source_file_name(call.volume);
  options.source_path_hash =
      call.source_path_hash.empty() ? source_path_hash(call.volume, store) : call.source_path_hash;
  options.content_key = call.volume_key + (call.resumes ? input_versions(files) : "");
  if (call.part) return build_part(call, *opened);
  if (auto replaceable = check_replaceable_store(store, options.source_path_hash, call.force);
      !replaceable) {
    return report(replaceable.error());
  }
  if (!call.joins) {
    const auto labels = looks_like_labels(*opened->source);
    if (labels && *labels) {
      note(
          "the volume looks like a segmentation: --labels makes a scene with a smooth surface for "
          "each of its labels");
    }
  }
  const auto parts = call.joins ? find_parts(store) : std::vector<std::filesystem::path>();
  const auto kept = kept_blocks(call, parts);
  if (!kept) return report(kept.error());
  options.kept = kept->get();
  const auto built = build_with_progress(*opened, store, options, call.builder);
  if (!built) return report(built.error());
  std::error_code ignored;
  if (call.resumes) std::filesystem::remove(unfinished_path(store), ignored);
  if (call.removes_parts) {
    for (const auto& part : parts) std::filesystem::remove(part, ignored);
  }
  if (!call.quiet) {
    print_result(store, *built);
    if (call.resumes && (*kept)->taken() > 0) {
      fmt::print("{} blocks were complete before\n", with_commas((*kept)->taken()));
    }
    if (call.joins && (*kept)->changed() > 0) {
      fmt::print(
          "{} blocks of the parts were encoded again: the size limit of the store reduces their "
          "bands, which a part cannot know\n",
          with_commas((*kept)->changed()));
    }
  }
  if (!call.no_thumbnail) {
    // The store is complete, and can be served without a picture.
    if (auto drawn = draw_thumbnail(store); !drawn) note("no thumbnail: " + drawn.error().message);
  }
  return kSuccess;
}

}  // namespace isosplat::cli
