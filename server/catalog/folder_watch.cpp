#include "server/catalog/folder_watch.h"

#include <fcntl.h>
#include <linux/magic.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <thread>

namespace isosplat::server {
namespace {

/// Related changes, such as those of copying a folder, arrive within this time.
constexpr std::chrono::milliseconds kCollected{20};

/// Maximum number of changes per call of wait(); the next call returns the others.
constexpr size_t kMaxChanges = 65536;

constexpr uint32_t kEvents = IN_CREATE | IN_CLOSE_WRITE | IN_MOVED_FROM | IN_MOVED_TO | IN_DELETE |
                             IN_ATTRIB | IN_MODIFY | IN_ONLYDIR;

// Whether inotify reports all changes in a folder. It does not report the changes that other
// machines make in a network file system. The numbers are from statfs(2), since linux/magic.h lacks
// them.
bool reports_changes(const std::string& folder) {
  constexpr std::array<uint64_t, 9> kRemote = {NFS_SUPER_MAGIC, SMB_SUPER_MAGIC,  0xff534d42,
                                               0xfe534d42,      FUSE_SUPER_MAGIC, V9FS_MAGIC,
                                               AFS_SUPER_MAGIC, CEPH_SUPER_MAGIC, CODA_SUPER_MAGIC};
  struct statfs system {};
  if (::statfs(folder.c_str(), &system) != 0) return false;
  const auto type = static_cast<uint64_t>(static_cast<uint32_t>(system.f_type));
  return std::find(kRemote.begin(), kRemote.end(), type) == kRemote.end();
}

bool is_same_folder(const std::string& a, const std::string& b) {
  struct stat first {
  }, second{};
  return ::stat(a.c_str(), &first) == 0 && ::stat(b.c_str(), &second) == 0 &&
         first.st_dev == second.st_dev && first.st_ino == second.st_ino;
}

}  // namespace

FolderWatch::FolderWatch()
    : inotify_(::inotify_init1(IN_NONBLOCK | IN_CLOEXEC)),
      wake_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

FolderWatch::~FolderWatch() {
  if (inotify_ >= 0) ::close(inotify_);
  if (wake_ >= 0) ::close(wake_);
}

bool FolderWatch::add(const std::string& folder) {
  if (inotify_ < 0 || wake_ < 0 || !reports_changes(folder)) return false;
  const int watch = ::inotify_add_watch(inotify_, folder.c_str(), kEvents);
  if (watch < 0) return false;
  const auto before = watches_.find(folder);
  if (before != watches_.end() && before->second != watch) {  // another folder has this path now
    ::inotify_rm_watch(inotify_, before->second);
    folders_.erase(before->second);
    watches_.erase(before);
  }
  // A folder has one watch. If the folder was renamed, the new name replaces the old one. If it has
  // both names (by a link or a mount), changes are reported for the first one.
  if (const auto other = folders_.find(watch); other != folders_.end() && other->second != folder) {
    if (is_same_folder(other->second, folder)) return false;
    watches_.erase(other->second);
  }
  folders_[watch] = folder;
  watches_[folder] = watch;
  return true;
}

void FolderWatch::remove(const std::string& folder) {
  const auto forget = [this](auto item) {
    ::inotify_rm_watch(inotify_, item->second);
    folders_.erase(item->second);
    return watches_.erase(item);
  };
  if (const auto self = watches_.find(folder); self != watches_.end()) forget(self);
  const std::string below = folder + '/';
  for (auto item = watches_.lower_bound(below);
       item != watches_.end() && item->first.starts_with(below);) {
    item = forget(item);
  }
}

FolderWatch::Changes FolderWatch::wait(std::chrono::milliseconds longest) {
  Changes changes;
  if (wake_ < 0) {
    std::this_thread::sleep_for(std::min(longest, std::chrono::milliseconds(100)));
    return changes;
  }
  std::array<pollfd, 2> ready = {pollfd{wake_, POLLIN, 0}, pollfd{inotify_, POLLIN, 0}};
  const auto milliseconds = std::min<int64_t>(longest.count(), INT32_MAX);
  ::poll(ready.data(), ready.size(), static_cast<int>(milliseconds));
  uint64_t count = 0;
  if (ready[0].revents & POLLIN) (void)!::read(wake_, &count, sizeof count);
  if (ready[1].revents & POLLIN) {
    std::this_thread::sleep_for(kCollected);
    read_events(changes);
  }
  return changes;
}

void FolderWatch::wake() {
  const uint64_t one = 1;
  (void)!::write(wake_, &one, sizeof one);
}

void FolderWatch::read_events(Changes& changes) {
  alignas(inotify_event) std::array<char, 64 * 1024> buffer;
  while (changes.list.size() < kMaxChanges) {
    const ssize_t bytes = ::read(inotify_, buffer.data(), buffer.size());
    if (bytes <= 0) return;
    for (ssize_t at = 0; at < bytes;) {
      inotify_event event;
      std::memcpy(&event, &buffer[static_cast<size_t>(at)], sizeof event);
      const char* const name = &buffer[static_cast<size_t>(at) + sizeof event];
      at += static_cast<ssize_t>(sizeof event) + event.len;
      if (event.mask & IN_Q_OVERFLOW) {
        changes.is_incomplete = true;
        continue;
      }
      const auto folder = folders_.find(event.wd);
      if (folder == folders_.end()) continue;  // no longer watched
      if (event.mask & IN_IGNORED) {           // the folder was removed
        watches_.erase(folder->second);
        folders_.erase(folder);
        continue;
      }
      if (event.len == 0) continue;  // a change of the folder itself
      FolderChange change{FolderChange::Kind::file, folder->second, name};
      if (event.mask & IN_ISDIR) {
        if (event.mask & IN_ATTRIB) continue;
        change.kind = FolderChange::Kind::folder;
      } else if (event.mask & (IN_CREATE | IN_MODIFY)) {
        change.kind = FolderChange::Kind::begun;
      }
      changes.list.push_back(std::move(change));
    }
  }
}

}  // namespace isosplat::server
