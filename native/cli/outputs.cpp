#include "native/cli/outputs.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "native/cli/building.h"
#include "native/files/output_file.h"

namespace isosplat::cli {
namespace {

bool exists_with_content(const std::filesystem::path& path) {
  return !first_bytes(path, 1).empty();
}

}  // namespace

StoredSource source_of(const StoreFile& store) {
  const auto metadata = nlohmann::json::parse(store.info().metadata, nullptr, false);
  if (!metadata.is_object() || !metadata.contains("source")) return {};
  const auto& source = metadata["source"];
  const auto text = [&](const char* key) {
    return source.is_object() && source.contains(key) && source[key].is_string()
               ? source[key].get<std::string>()
               : std::string();
  };
  return {text("file"), text("path_hash")};
}

Result<void> check_not_input(const std::filesystem::path& output,
                             std::span<const std::filesystem::path> inputs) {
  for (const std::filesystem::path& input : inputs) {
    std::error_code error;
    if (std::filesystem::equivalent(output, input, error)) {
      return fail(Status::invalid_argument,
                  fmt::format("{}: expected an output that is not an input, found the input {}: "
                              "give another name with -o",
                              output.string(), input.string()));
    }
  }
  return {};
}

Result<void> check_replaceable(const std::filesystem::path& output, std::string_view beginning,
                               std::string_view kind, bool force) {
  if (force || !exists_with_content(output) || first_bytes(output, beginning.size()) == beginning)
    return {};
  return fail(Status::invalid_argument,
              fmt::format("{}: expected no file, or {}, found another file: give another name "
                          "with -o, or replace it with --force",
                          output.string(), kind));
}

Result<void> check_replaceable_bundle(const std::filesystem::path& output, bool force) {
  return check_replaceable(output, "\x89ISOB", "a bundle", force);
}

Result<void> check_replaceable_store(const std::filesystem::path& store,
                                     std::string_view source_path_hash, bool force) {
  if (force || !exists_with_content(store)) return {};
  if (!is_store(store)) {
    return fail(Status::invalid_argument,
                fmt::format("{}: expected no file, or a store, found another file: give another "
                            "name with -o, or replace it with --force",
                            store.string()));
  }
  const auto opened = StoreFile::open(store);
  const StoredSource source = opened ? source_of(**opened) : StoredSource{};
  if (source.path_hash == source_path_hash) return {};
  return fail(
      Status::invalid_argument,
      fmt::format("{}: expected no file, or a store of the same volume, found a store of "
                  "{}: give another name with -o, or replace it with --force",
                  store.string(),
                  source.file.empty() ? "an unknown volume" : "another volume, " + source.file));
}

}  // namespace isosplat::cli
