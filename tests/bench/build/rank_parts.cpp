// Measures the parts of a build by several ranks (docs/scale.md): builds a store in one thread with
// the messages that ranks exchange, and prints the processor time and the bytes of each part as one
// line of JSON: isosplat_rank_parts_bench VOLUME.raw NX NY NZ
// The voxels have 16 bits. Times are in seconds, bytes in MB.
#include <ctime>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "shared/core/builder/block_transfer.h"
#include "shared/core/builder/store_build.h"
#include "shared/system/posix_file/posix_file.h"

namespace isosplat {
namespace {

class RawVolume : public VolumeSource {
 public:
  RawVolume(PosixFile file, Index3 voxels) : file_(std::move(file)) {
    header_.grid.voxels = voxels;
    header_.type = VoxelType::i16;
    header_.format = "raw";
    header_.name = "volume";
  }
  const VolumeHeader& header() const override { return header_; }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    return file_.read(out.size() / static_cast<size_t>(count) * static_cast<uint64_t>(first), out);
  }
  uint64_t resident_bytes() const override { return 0; }
  std::vector<std::filesystem::path> files() const override { return {}; }

 private:
  PosixFile file_;
  VolumeHeader header_;
};

class FileOutput : public ByteSink {
 public:
  explicit FileOutput(PosixFile file) : file_(std::move(file)) {}
  Result<void> write(uint64_t offset, std::span<const std::byte> bytes) override {
    return file_.write(offset, bytes);
  }

 private:
  PosixFile file_;
};

/// Adds the processor time of its scope.
class Timer {
 public:
  explicit Timer(double& seconds) : seconds_(seconds), start_(now()) {}
  ~Timer() { seconds_ += now() - start_; }
  Timer(const Timer&) = delete;

 private:
  static double now() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
  }
  double& seconds_;
  const double start_;
};

/// Of level 0, or of all coarser levels.
struct Parts {
  double read = 0;     ///< reads and quantizes layers
  double send = 0;     ///< copies the voxels of blocks to messages
  double encode = 0;   ///< encodes the blocks of messages
  double receive = 0;  ///< copies the coarser level's part, and writes the chunks
  double task_mb = 0, encoded_mb = 0;
};

void print(const char* name, const Parts& parts) {
  std::printf(
      "\"%s\":{\"read\":%.4f,\"send\":%.4f,\"encode\":%.4f,\"receive\":%.4f,\"taskMB\":%.3f,"
      "\"encodedMB\":%.3f},",
      name, parts.read, parts.send, parts.encode, parts.receive, parts.task_mb, parts.encoded_mb);
}

Result<void> build_by_messages(StoreBuild& build, Index3 volume, std::array<Parts, 2>& all,
                               double& begin) {
  {
    const Timer timer(begin);
    if (auto begun = build.begin(); !begun) return begun;
  }
  BlockEncoder encoder;
  std::vector<std::byte> task_message, encoded_message;
  for (;;) {
    const auto has_layer = build.advance_layer();
    if (!has_layer) return tl::unexpected(has_layer.error());
    if (!*has_layer) break;
    Parts& parts = all[build.layer().grid.level > 0];
    {
      const Timer timer(parts.read);
      if (auto loaded = build.load_layer(true); !loaded) return loaded;
    }
    while (const auto task = build.begin_block()) {
      {
        const Timer timer(parts.send);
        write_task(build.layer(), build.coarser(), *task, volume, task_message);
      }
      {
        const Timer timer(parts.encode);
        const auto encoded =
            encode_task(task_message, build.isovalue_distribution(), encoder, encoded_message);
        if (!encoded) return encoded;
      }
      const Timer timer(parts.receive);
      EncodedBlock block;
      const auto number = read_encoded(encoded_message, build.layer(), build.coarser(), block);
      if (!number) return tl::unexpected(number.error());
      if (auto added = build.add_block(*number, std::move(block)); !added) return added;
      parts.task_mb += static_cast<double>(task_message.size()) * 1e-6;
      parts.encoded_mb += static_cast<double>(encoded_message.size()) * 1e-6;
    }
  }
  const auto finished = build.finish(encoder.statistics);
  return finished ? Result<void>() : tl::unexpected(finished.error());
}

int run(char** arguments) {
  const auto give_up = [](const Error& error) {
    std::fprintf(stderr, "%s\n", error.message.c_str());
    return 1;
  };
  const Index3 voxels{std::atoi(arguments[2]), std::atoi(arguments[3]), std::atoi(arguments[4])};
  auto file = PosixFile::open(arguments[1]);
  if (!file) return give_up(file.error());
  auto output = PosixFile::create_temporary(std::filesystem::temp_directory_path());
  if (!output) return give_up(output.error());
  RawVolume volume(std::move(*file), voxels);
  FileOutput sink(std::move(*output));
  SerialExecutor executor;
  StoreOptions options;
  StoreBuild build(volume, sink, options, executor, 1, nullptr);
  std::array<Parts, 2> parts;
  double begin = 0;
  if (auto built = build_by_messages(build, voxels, parts, begin); !built) {
    return give_up(built.error());
  }
  std::printf("{\"begin\":%.4f,", begin);
  print("finest", parts[0]);
  print("coarser", parts[1]);
  std::printf("\"voxels\":%.0f}\n", double{1} * voxels.x * voxels.y * voxels.z);
  return 0;
}

}  // namespace
}  // namespace isosplat

int main(int count, char** arguments) {
  if (count != 5) {
    std::fprintf(stderr, "expected: isosplat_rank_parts_bench VOLUME.raw NX NY NZ\n");
    return 2;
  }
  return isosplat::run(arguments);
}
