#include "shared/bindings/wasm/builder_api.h"

#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "shared/bindings/wasm/builder_host.h"
#include "shared/bindings/wasm/volume_text.h"
#include "shared/core/builder/block_transfer.h"
#include "shared/core/builder/store_build.h"

using namespace isosplat;

namespace {

Result<void> result_of(uint32_t host_status) {
  if (host_status == 0) return {};
  std::string message(2048, '\0');
  message.resize(isosplat_host_error(message.data(), static_cast<uint32_t>(message.size())));
  return fail(Status::io_error, std::move(message));
}

class HostSource : public VolumeSource {
 public:
  explicit HostSource(const VolumeHeader& header) : header_(header) {}
  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return result_of(isosplat_host_read_slices(static_cast<uint32_t>(first),
                                               static_cast<uint32_t>(count), out.data(),
                                               static_cast<uint32_t>(out.size())));
  }
  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  const VolumeHeader& header_;
};

class HostSink : public ByteSink {
 public:
  Result<void> write(uint64_t offset, std::span<const std::byte> bytes) override {
    return result_of(isosplat_host_write(static_cast<double>(offset), bytes.data(),
                                         static_cast<uint32_t>(bytes.size())));
  }
};

/// A build, and the objects to which it keeps references.
struct Build {
  explicit Build(DescribedVolume described)
      : volume(std::move(described)),
        source(volume.header),
        build(source, sink, volume.options, executor, volume.encoders, nullptr) {}

  DescribedVolume volume;
  HostSource source;
  HostSink sink;
  SerialExecutor executor;
  StoreBuild build;
  VolumeStatistics statistics;
  bool has_layers = true;
};

}  // namespace

struct IsosplatBuilder {
  std::unique_ptr<Build> build;
  std::unique_ptr<BlockEncoder> encoder;
  std::vector<double> isovalue_distribution;  ///< of the encoder
  std::string error;
  std::array<std::vector<std::byte>, 2> results;
};

namespace {

uint32_t report(IsosplatBuilder* builder, const Error& error) {
  builder->error = error.message;
  return static_cast<uint32_t>(error.status);
}

uint32_t report(IsosplatBuilder* builder, const Result<void>& result) {
  return result ? 0 : report(builder, result.error());
}

uint32_t not_begun(IsosplatBuilder* builder) {
  return report(builder, Error{Status::invalid_argument,
                               "there is no build or encoder: call begin or set_up first"});
}

std::span<const std::byte> as_bytes(const void* data, uint32_t bytes) {
  return {static_cast<const std::byte*>(data), bytes};
}

void put(std::vector<std::byte>& result, const void* data, size_t bytes) {
  const auto* from = static_cast<const std::byte*>(data);
  result.assign(from, from + bytes);
}

}  // namespace

extern "C" {

IsosplatBuilder* isosplat_builder_create(void) {
  return new IsosplatBuilder;
}

void isosplat_builder_destroy(IsosplatBuilder* builder) {
  delete builder;
}

const char* isosplat_builder_error(const IsosplatBuilder* builder) {
  return builder->error.c_str();
}

const char* isosplat_builder_status_name(uint32_t status) {
  // The names are literals, which end in a null.
  return status_name(static_cast<Status>(status)).data();
}

const void* isosplat_builder_result(const IsosplatBuilder* builder, uint32_t buffer) {
  return buffer < builder->results.size() ? builder->results[buffer].data() : nullptr;
}

uint32_t isosplat_builder_result_bytes(const IsosplatBuilder* builder, uint32_t buffer) {
  return buffer < builder->results.size() ? static_cast<uint32_t>(builder->results[buffer].size())
                                          : 0;
}

uint32_t isosplat_builder_begin(IsosplatBuilder* builder, const char* volume, uint32_t bytes) {
  auto described = parse_volume({volume, bytes});
  if (!described) return report(builder, described.error());
  described->options.progress = [](const BuildProgress& progress) {
    isosplat_host_progress(progress.fraction, progress.voxels_per_second, progress.seconds_left);
  };
  builder->build = std::make_unique<Build>(std::move(*described));
  StoreBuild& build = builder->build->build;
  if (auto begun = build.begin(); !begun) return report(builder, begun);
  const std::vector<double>& distribution = build.isovalue_distribution();
  put(builder->results[0], distribution.data(), distribution.size() * sizeof(double));
  return 0;
}

uint32_t isosplat_builder_next(IsosplatBuilder* builder) {
  if (!builder->build) return not_begun(builder);
  Build& own = *builder->build;
  uint32_t next = ISOSPLAT_NEXT_WAIT;
  builder->results[0].clear();
  if (own.has_layers && own.build.layer_is_complete()) {
    const auto has_layer = own.build.next_layer();
    if (!has_layer) return report(builder, has_layer.error());
    own.has_layers = *has_layer;
  }
  if (!own.has_layers) {
    next = ISOSPLAT_NEXT_COMPLETE;
  } else if (const auto task = own.build.begin_block()) {
    write_task(own.build.layer(), own.build.coarser(), *task, own.volume.header.grid.voxels,
               builder->results[0]);
    next = ISOSPLAT_NEXT_TASK;
  }
  put(builder->results[1], &next, sizeof next);
  return 0;
}

uint32_t isosplat_builder_add(IsosplatBuilder* builder, const void* block, uint32_t bytes) {
  if (!builder->build) return not_begun(builder);
  StoreBuild& build = builder->build->build;
  EncodedBlock encoded;
  const auto number = read_encoded(as_bytes(block, bytes), build.layer(), build.coarser(), encoded);
  if (!number) return report(builder, number.error());
  return report(builder, build.add_block(*number, std::move(encoded)));
}

uint32_t isosplat_builder_add_statistics(IsosplatBuilder* builder, const void* statistics,
                                         uint32_t bytes) {
  if (!builder->build) return not_begun(builder);
  return report(builder, builder->build->statistics.add(as_bytes(statistics, bytes)));
}

uint32_t isosplat_builder_finish(IsosplatBuilder* builder) {
  if (!builder->build) return not_begun(builder);
  const auto finished = builder->build->build.finish(builder->build->statistics);
  if (!finished) return report(builder, finished.error());
  const std::string text = report_text(*finished);
  put(builder->results[0], text.data(), text.size());
  builder->build.reset();
  return 0;
}

uint32_t isosplat_builder_set_up(IsosplatBuilder* builder, const void* setup, uint32_t bytes) {
  if (bytes != 65537 * sizeof(double)) {
    return report(builder, Error{Status::invalid_argument,
                                 "the setup of an encoder is of another version, or incomplete: "
                                 "load the page again"});
  }
  builder->isovalue_distribution.resize(bytes / sizeof(double));
  std::memcpy(builder->isovalue_distribution.data(), setup, bytes);
  builder->encoder = std::make_unique<BlockEncoder>();
  return 0;
}

uint32_t isosplat_builder_encode(IsosplatBuilder* builder, const void* task, uint32_t bytes) {
  if (!builder->encoder) return not_begun(builder);
  return report(builder, encode_task(as_bytes(task, bytes), builder->isovalue_distribution,
                                     *builder->encoder, builder->results[0]));
}

uint32_t isosplat_builder_statistics(IsosplatBuilder* builder) {
  if (!builder->encoder) return not_begun(builder);
  builder->results[0] = builder->encoder->statistics.bytes();
  return 0;
}

}  // extern "C"
