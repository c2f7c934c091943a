#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <fstream>

#include "shared/import/open_volume.h"
#include "tests/native/temporary_folder.h"
#include "tests/native/volume_files.h"

namespace isosplat::import {
namespace {

/// Counts how often any program opens a file.
class Openings {
 public:
  explicit Openings(const std::filesystem::path& path) {
    EXPECT_GE(inotify_add_watch(queue_, path.c_str(), IN_OPEN | IN_CLOSE), 0);
  }
  Openings(const Openings&) = delete;
  Openings& operator=(const Openings&) = delete;
  ~Openings() { close(queue_); }

  int count() const {
    int openings = 0;
    alignas(inotify_event) std::array<char, 4096> events{};
    for (ssize_t bytes; (bytes = read(queue_, events.data(), events.size())) > 0;) {
      for (ssize_t at = 0; at < bytes;) {
        const auto* event = reinterpret_cast<const inotify_event*>(events.data() + at);
        at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
        // inotify merges equal events that follow each other. Between two events of opening there
        // is one of closing, so none are merged.
        if ((event->mask & IN_OPEN) != 0) ++openings;
      }
    }
    return openings;
  }

 private:
  int queue_ = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
};

TEST(FileHead, IsReadOnceToDetectTheFormat) {
  const TemporaryFolder folder;
  const std::string nrrd =
      test::nrrd_header({2, 2, 2}, "uchar", "encoding: raw\n\n") + std::string(8, '\1');
  std::string dicom(200, '\0');  // without the prefix
  dicom.replace(0, 8, std::string("\x08\0\x05\0CS\x0a\0", 8));
  struct Case {
    const char* name;
    std::string bytes;
    const char* format;
    int openings = 1;
  };
  const Case cases[] = {
      {"v.nrrd", nrrd, "NRRD"},
      {"v.img", "voxels of nothing", ""},
      {"v.nii", std::string(500, '\1'), "NIfTI"},
      {"v.map", "no map", ""},
      {"v.raw", std::string(8, '\1'), "raw"},
      {"IM0001", dicom, "DICOM"},
      {"v.txt", "a text\n", ""},
      {"v.nrrd.gz", test::deflated(nrrd), "NRRD", 2},  // as it is, and decompressed
  };
  for (const Case& each : cases) {
    const std::filesystem::path path = folder.path() / each.name;
    std::ofstream(path, std::ios::binary) << each.bytes;
    const Openings openings(path);
    EXPECT_EQ(format_of_file(path), each.format) << each.name;
    EXPECT_EQ(openings.count(), each.openings) << each.name;
  }
}

}  // namespace
}  // namespace isosplat::import
