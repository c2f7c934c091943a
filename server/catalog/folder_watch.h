#pragma once

#include <chrono>
#include <map>
#include <string>
#include <vector>

namespace isosplat::server {

/// A change in a watched folder.
struct FolderChange {
  enum class Kind {
    file,    ///< a file appeared, was closed after it was written, was replaced or removed
    begun,   ///< a file was created, written to or truncated, and may not be complete
    folder,  ///< a folder appeared, or was renamed or removed
  };
  Kind kind = Kind::file;
  std::string folder;  ///< as given to add()
  std::string name;    ///< in this folder
};

/// Watches folders with inotify. Not thread-safe, except for wake().
class FolderWatch {
 public:
  FolderWatch();
  ~FolderWatch();
  FolderWatch(const FolderWatch&) = delete;
  FolderWatch& operator=(const FolderWatch&) = delete;

  /// Watches a folder, without its subfolders. Returns false if the system does not report its
  /// changes: it is on a network or user-space file system, the limit of watches is reached, or the
  /// same folder is already watched by another path.
  bool add(const std::string& folder);

  /// Stops watching a folder and all folders below it.
  void remove(const std::string& folder);

  struct Changes {
    std::vector<FolderChange> list;
    bool is_incomplete = false;  ///< too many for the system: anything may have changed
  };

  /// Waits for changes, at most for this time, and until wake().
  Changes wait(std::chrono::milliseconds longest);

  /// Ends the wait in progress, or the next one. Thread-safe.
  void wake();

 private:
  void read_events(Changes& changes);

  int inotify_ = -1;  ///< -1: the system has none left
  int wake_ = -1;
  std::map<int, std::string> folders_;  ///< by watch
  std::map<std::string, int> watches_;  ///< by folder
};

}  // namespace isosplat::server
