#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/catalog/catalog_entries.h"
#include "server/catalog/scene_json.h"
#include "shared/system/scene_file/bundle_bytes.h"

namespace isosplat::server {

/// A scene as it is served: as the bytes of a bundle.
struct ServedScene {
  BundleBytes bytes;
  SceneFacts facts;
  std::filesystem::path path;  ///< of its file, as in the messages of errors
};

/// Removes a folder from the message of an error: clients may read the message, and must not learn
/// folders.
Error without_folder(Error error, const std::filesystem::path& folder);

/// Opens scenes when they are requested, and keeps the most recently used ones. Thread-safe.
class ScenePool {
 public:
  using Log = std::function<void(std::string_view)>;
  using OutsideLinks = CatalogEntries::OutsideLinks;

  struct Limits {
    size_t scenes = 64;                    ///< kept, in addition to those in use
    uint64_t bytes = uint64_t{128} << 20;  ///< of the headers of these
  };
  ScenePool(Limits limits, OutsideLinks links, Log log)
      : limits_(limits), links_(links), log_(std::move(log)) {}

  /// Returns the scene of an entry, after reading the headers of its stores. With `no_wait`, fails
  /// if the scene is not open, and sets no_wait->needs_disk. Errors: those of SceneFile::open and
  /// BundleBytes::plan, without the folder; out_of_memory if the system has no file descriptors
  /// left.
  Result<std::shared_ptr<const ServedScene>> open(const CatalogEntry& entry,
                                                  NoWait* no_wait = nullptr);

  /// Returns a summary of an entry's scene, which is read once. Null if this must wait for the disk
  /// and `no_wait` is given, which is then set.
  std::shared_ptr<const StoreSummary> summary(const CatalogEntry& entry, NoWait* no_wait = nullptr);

  /// The paths of scenes whose stores have changed although the scene's file has not, or whose
  /// error has changed. Reads files, but takes at most a twentieth of the time. Closes scenes that
  /// are no longer in the snapshot. Call it regularly, from one thread.
  std::vector<std::filesystem::path> examine(const CatalogSnapshot& snapshot);

  size_t size() const;  ///< scenes that are open now

  /// A number that changes with each new summary of a scene.
  uint64_t news() const { return news_; }

 private:
  using Clock = std::chrono::steady_clock;

  struct Open {
    uint64_t id = 0;  ///< of the entry
    std::string name;
    std::filesystem::path path;
    std::shared_ptr<const ServedScene> scene;
  };
  using Position = std::list<Open>::iterator;

  Result<std::shared_ptr<const ServedScene>> open_file(const CatalogEntry& entry) const;
  std::shared_ptr<const StoreSummary> remember(
      const CatalogEntry& entry, const Result<std::shared_ptr<const ServedScene>>& scene);
  std::shared_ptr<const ServedScene> find(uint64_t id);
  void keep(const CatalogEntry& entry, const std::shared_ptr<const ServedScene>& scene);
  void close(Position position);
  bool has_other_error(const CatalogEntry& entry) const;

  const Limits limits_;
  const OutsideLinks links_;
  const Log log_;
  std::atomic<uint64_t> news_{0};
  Clock::time_point last_examination_{};  // of the thread that calls examine()
  Clock::duration examination_time_{};    // the same

  mutable std::mutex mutex_;
  std::list<Open> by_use_;                            // guarded by mutex_; the last used first
  std::unordered_map<uint64_t, Position> positions_;  // guarded by mutex_; by id
  uint64_t bytes_ = 0;                                // guarded by mutex_
  std::vector<std::filesystem::path> stale_;          // guarded by mutex_
};

}  // namespace isosplat::server
