#include "shared/bindings/wasm/import_api.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "shared/bindings/wasm/import_text.h"
#include "shared/import/open_volume.h"

using namespace isosplat;

struct IsosplatImport {
  std::unique_ptr<VolumeSource> source;
  std::string error;
  std::vector<std::byte> result;
};

namespace {

constexpr uint64_t kMaxRead = uint64_t{1} << 30;

uint32_t report(IsosplatImport* importer, const Error& error) {
  importer->error = error.message;
  return static_cast<uint32_t>(error.status);
}

void put(IsosplatImport* importer, std::string_view text) {
  const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
  importer->result.assign(bytes, bytes + text.size());
}

}  // namespace

extern "C" {

IsosplatImport* isosplat_import_create(void) {
  return new IsosplatImport;
}

void isosplat_import_destroy(IsosplatImport* importer) {
  delete importer;
}

const char* isosplat_import_error(const IsosplatImport* importer) {
  return importer->error.c_str();
}

const char* isosplat_import_status_name(uint32_t status) {
  return status_name(static_cast<Status>(status)).data();
}

const void* isosplat_import_result(const IsosplatImport* importer) {
  return importer->result.data();
}

uint32_t isosplat_import_result_bytes(const IsosplatImport* importer) {
  return static_cast<uint32_t>(importer->result.size());
}

uint32_t isosplat_import_detect(IsosplatImport* importer, const char* path, uint32_t bytes) {
  put(importer, import::format_of_file(std::filesystem::path(std::string(path, bytes))));
  return 0;
}

uint32_t isosplat_import_packing(IsosplatImport* importer, const char* path, uint32_t bytes) {
  put(importer, import::packing_of_file(std::filesystem::path(std::string(path, bytes))));
  return 0;
}

uint32_t isosplat_import_choices(IsosplatImport* importer, const char* path, uint32_t bytes) {
  const auto volumes = import::volumes_in_file(std::filesystem::path(std::string(path, bytes)));
  if (!volumes) return report(importer, volumes.error());
  put(importer, choices_text(*volumes));
  return 0;
}

uint32_t isosplat_import_open(IsosplatImport* importer, const char* request, uint32_t bytes) {
  importer->source.reset();
  auto parsed = parse_import_request({request, bytes});
  if (!parsed) {
    put(importer, choices_text({}));
    return report(importer, parsed.error());
  }
  std::vector<import::VolumeChoice> choices;
  parsed->options.choices = &choices;
  auto volume = import::open_volume(parsed->path, parsed->options);
  if (!volume) {
    put(importer, choices_text(choices));
    return report(importer, volume.error());
  }
  put(importer, imported_text(parsed->path, *volume, choices));
  importer->source = std::move(volume->source);
  return 0;
}

uint32_t isosplat_import_read_slices(IsosplatImport* importer, uint32_t first, uint32_t count) {
  if (!importer->source) {
    return report(importer, {Status::invalid_argument, "no volume is open: call open first"});
  }
  const VolumeHeader& header = importer->source->header();
  const Index3 n = header.grid.voxels;
  const auto slices = static_cast<uint32_t>(n.z);
  const uint64_t slice =
      static_cast<uint64_t>(n.x) * static_cast<uint64_t>(n.y) * voxel_bytes(header.type);
  if (count < 1 || first >= slices || count > slices - first || slice * count > kMaxRead) {
    return report(importer, {Status::invalid_argument,
                             "expected slices of the volume, at most 1 GiB at a time"});
  }
  importer->result.resize(static_cast<size_t>(slice * count));
  const auto read = importer->source->read_slices(static_cast<int32_t>(first),
                                                  static_cast<int32_t>(count), importer->result);
  return read ? 0 : report(importer, read.error());
}

}  // extern "C"
