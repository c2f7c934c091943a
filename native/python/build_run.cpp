#include "native/python/build_run.h"

#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "native/builder/output_build.h"

namespace py = pybind11;

namespace isosplat::python {
namespace {

using std::chrono::milliseconds;

/// A volume that cannot be read any more once the build is to end.
class StoppableSource : public VolumeSource {
 public:
  StoppableSource(VolumeSource& volume, const Interruption& interruption)
      : volume_(volume), interruption_(interruption) {}

  const VolumeHeader& header() const override { return volume_.header(); }
  Result<void> read_slices(int32_t first, int32_t count, std::span<std::byte> out) override {
    if (auto go_on = interruption_.check(); !go_on) return go_on;
    return volume_.read_slices(first, count, out);
  }
  bool reads_rows() const override { return volume_.reads_rows(); }
  Result<void> read_rows(const SliceRows& part, std::span<std::byte> out) override {
    if (auto go_on = interruption_.check(); !go_on) return go_on;
    return volume_.read_rows(part, out);
  }
  uint64_t resident_bytes() const override { return volume_.resident_bytes(); }
  std::vector<std::filesystem::path> files() const override { return volume_.files(); }

 private:
  VolumeSource& volume_;
  const Interruption& interruption_;
};

/// The same of a volume that it owns.
class StoppableField : public StoppableSource {
 public:
  StoppableField(std::unique_ptr<VolumeSource> volume, const Interruption& interruption)
      : StoppableSource(*volume, interruption), owned_(std::move(volume)) {}

 private:
  std::unique_ptr<VolumeSource> owned_;
};

/// A file that cannot be written any more once the build is to end.
class StoppableSink : public ByteSink {
 public:
  StoppableSink(ByteSink& sink, const Interruption& interruption)
      : sink_(sink), interruption_(interruption) {}

  Result<void> write(uint64_t offset, std::span<const std::byte> bytes) override {
    if (auto go_on = interruption_.check(); !go_on) return go_on;
    return sink_.write(offset, bytes);
  }

 private:
  ByteSink& sink_;
  const Interruption& interruption_;
};

/// What the building thread reports to the waiting one.
class BuildState {
 public:
  void set_progress(const BuildProgress& progress) {
    const std::lock_guard lock(mutex_);
    phase_ = progress.phase;
    fraction_ = progress.fraction;
  }
  void set_result(Result<BuildReport> result) {
    {
      const std::lock_guard lock(mutex_);
      result_ = std::move(result);
    }
    done_.notify_all();
  }
  /// Waits for the end of the build. False if it goes on for longer.
  bool wait_for(milliseconds time) {
    std::unique_lock lock(mutex_);
    return done_.wait_for(lock, time, [this] { return result_.has_value(); });
  }
  std::pair<double, std::string> progress() {
    const std::lock_guard lock(mutex_);
    return {fraction_, phase_};
  }
  /// Call after the end.
  const Result<BuildReport>& result() const { return *result_; }

 private:
  std::mutex mutex_;
  std::condition_variable done_;
  std::string phase_ = "opened";
  double fraction_ = 0;
  std::optional<Result<BuildReport>> result_;
};

/// Calls progress(fraction, phase), unless it is None. An exception ends the build.
void call_progress(const py::object& progress, const std::pair<double, std::string>& now,
                   Interruption& interruption) {
  if (progress.is_none()) return;
  try {
    progress(now.first, now.second);
  } catch (...) {
    interruption.set_current_exception();
  }
}

}  // namespace

void run_build(const import::OpenVolume& volume, const std::filesystem::path& target,
               BuildOptions options, const py::object& progress, Interruption& interruption,
               std::vector<FieldInput> fields) {
  BuildState state;
  options.notes = volume.notes;
  options.progress = [&state](const BuildProgress& now) { state.set_progress(now); };
  StoppableSource source(*volume.source, interruption);
  for (FieldInput& field : fields) {
    field.open = [open = std::move(field.open),
                  &interruption]() -> Result<std::unique_ptr<VolumeSource>> {
      auto opened = open();
      if (!opened) return opened;
      return std::make_unique<StoppableField>(std::move(*opened), interruption);
    };
  }
  const auto build = [&]() -> Result<BuildReport> {
    try {
      return build_output_file(target, options, [&](ByteSink& file, const BuildOptions& all) {
        StoppableSink sink(file, interruption);
        auto report = fields.empty() ? build_store(source, sink, all)
                                     : build_store_with_fields(source, fields, sink, target, all);
        // The file is published after this, but not after Ctrl-C.
        if (const auto go_on = interruption.check(); report && !go_on) {
          report = tl::unexpected(go_on.error());
        }
        return report;
      });
    } catch (const std::exception& failure) {
      return fail(Status::out_of_memory, failure.what());
    }
  };
  double last = 0;
  call_progress(progress, state.progress(), interruption);
  interruption.rethrow();
  std::thread thread([&] { state.set_result(build()); });
  const auto wait = [&] {
    const py::gil_scoped_release no_gil;
    const bool is_done = state.wait_for(milliseconds(50));
    if (is_done) thread.join();
    return is_done;
  };
  while (!wait()) {
    interruption.handle_signals();
    const auto now = state.progress();
    // After an exception, the loop waits for the thread without further calls.
    if (now.first == last || !interruption.check()) continue;
    last = now.first;
    call_progress(progress, now, interruption);
  }
  interruption.rethrow();
  value_or_raise(state.result());
  if (!progress.is_none()) progress(1.0, "complete");
}

}  // namespace isosplat::python
