// Files of the operating system: their identity, reading at offsets and at the end, pipes and
// folders.

#include "shared/system/posix_file/posix_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <chrono>
#include <fstream>

#include "tests/native/temporary_folder.h"

namespace isosplat {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

class PosixFiles : public ::testing::Test {
 protected:
  void write(const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

  TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "some.bytes";
};

TEST_F(PosixFiles, AreReadAtOffsetsUpToTheirEnd) {
  write("0123456789");
  const auto file = PosixFile::open(path);
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->identity()->bytes, 10u);
  std::string text(4, '.');
  const auto out = std::as_writable_bytes(std::span(text));
  ASSERT_TRUE(file->read(3, out));
  EXPECT_EQ(text, "3456");
  EXPECT_EQ(*file->read_some(8, out), 2u);
  EXPECT_EQ(text, "8956");
  EXPECT_EQ(*file->read_some(11, out), 0u);
  const auto cut = file->read(8, out);
  ASSERT_FALSE(cut);
  EXPECT_EQ(cut.error().status, Status::truncated);
  EXPECT_TRUE(cut.error().message.starts_with(path.string() + ": expected 4 bytes at offset 8"));
}

TEST_F(PosixFiles, AreReadWithoutWaitingOrReportThatTheyNeedTheDisk) {
  write("0123456789");
  const auto file = PosixFile::open(path);
  ASSERT_TRUE(file) << file.error().message;
  std::string text(4, '.');
  const auto out = std::as_writable_bytes(std::span(text));
  // Bytes that were just written are in memory, but not every file system reports this.
  NoWait no_wait;
  const auto read = file->read(3, out, &no_wait);
  EXPECT_EQ(read.has_value(), !no_wait.needs_disk);
  EXPECT_EQ(text, read ? "3456" : "....");
  if (!read) {
    EXPECT_EQ(read.error().status, Status::io_error);
    return;
  }
  // A read beyond the end of the file does not wait for the disk.
  NoWait at_end;
  EXPECT_EQ(file->read(8, out, &at_end).error().status, Status::truncated);
  EXPECT_FALSE(at_end.needs_disk);
}

TEST_F(PosixFiles, AFileOfAFileSystemInMemoryNeverWaits) {
  struct statfs system {};
  if (::statfs("/dev/shm", &system) != 0 || system.f_type != TMPFS_MAGIC) {
    GTEST_SKIP() << "/dev/shm is no tmpfs";
  }
  const std::string name = "/dev/shm/isosplat-posix-file-test-" + std::to_string(::getpid());
  std::ofstream(name) << "0123456789";
  const auto file = PosixFile::open(name);
  ::unlink(name.c_str());
  ASSERT_TRUE(file) << file.error().message;
  std::string text(4, '.');
  NoWait no_wait;
  EXPECT_TRUE(file->read(3, std::as_writable_bytes(std::span(text)), &no_wait));
  EXPECT_TRUE(file->identity(&no_wait));
  EXPECT_FALSE(no_wait.needs_disk);
  EXPECT_EQ(text, "3456");
}

TEST_F(PosixFiles, AFileThatIsReplacedIsAnotherAndItsHolderKeepsTheOldOne) {
  write("old");
  const auto file = PosixFile::open(path);
  ASSERT_TRUE(file);
  const auto before = file_identity(path);
  ASSERT_TRUE(before);
  EXPECT_EQ(*before, *file->identity());
  std::ofstream(folder.path() / "new") << "new";
  std::filesystem::rename(folder.path() / "new", path);
  EXPECT_FALSE(*file_identity(path) == *before);
  EXPECT_TRUE(file->identity()->has_same_content(*before));
  std::string text(3, '.');
  ASSERT_TRUE(file->read(0, std::as_writable_bytes(std::span(text))));
  EXPECT_EQ(text, "old");
}

TEST_F(PosixFiles, AFileThatIsWrittenToHasOtherContent) {
  write("old");
  const auto before = file_identity(path);
  write("longer");
  EXPECT_FALSE(file_identity(path)->has_same_content(*before));
  write("old");
  std::filesystem::last_write_time(
      path, std::filesystem::file_time_type::clock::now() - std::chrono::hours(1));
  EXPECT_FALSE(file_identity(path)->has_same_content(*before));
}

TEST_F(PosixFiles, FoldersPipesAndMissingFilesAreRefusedWithoutWaiting) {
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  for (const auto& [name, reason] : std::vector<std::pair<std::filesystem::path, std::string>>{
           {path, "found a pipe"},
           {folder.path(), "found a folder"},
           {"/dev/null", "found a device"},
           {folder.path() / "none", "cannot be opened: No such file"}}) {
    for (const auto& refused : {PosixFile::open(name).map([](const PosixFile&) {}),
                                file_identity(name).map([](const FileIdentity&) {})}) {
      ASSERT_FALSE(refused) << name;
      EXPECT_EQ(refused.error().status, Status::io_error);
      EXPECT_TRUE(refused.error().message.starts_with(name.string() + ": "));
      EXPECT_NE(refused.error().message.find(reason), std::string::npos) << refused.error().message;
    }
  }
}

TEST_F(PosixFiles, TemporariesHaveNoNameAndKeepWhatIsWritten) {
  auto file = PosixFile::create_temporary(folder.path());
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  ASSERT_TRUE(file->write(5, bytes_of("fifth")));
  ASSERT_TRUE(file->write(0, bytes_of("first")));
  std::string text(10, '.');
  ASSERT_TRUE(file->read(0, std::as_writable_bytes(std::span(text))));
  EXPECT_EQ(text, "firstfifth");
  const auto refused = PosixFile::create_temporary(folder.path() / "none");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().status, Status::io_error);
}

TEST_F(PosixFiles, AFullDiskNamesTheRemedy) {
  PosixFile full(::open("/dev/full", O_WRONLY | O_CLOEXEC), "some.bytes");
  ASSERT_TRUE(full.is_open());
  const auto written = full.write(0, bytes_of("x"));
  ASSERT_FALSE(written);
  EXPECT_TRUE(written.error().message.starts_with("some.bytes: cannot be written: "));
  EXPECT_NE(written.error().message.find("free some space"), std::string::npos);
}

TEST_F(PosixFiles, AMovedFileIsClosedOnce) {
  write("0123456789");
  auto file = PosixFile::open(path);
  ASSERT_TRUE(file);
  const int descriptor = file->descriptor();
  PosixFile other = std::move(*file);
  EXPECT_FALSE(file->is_open());
  EXPECT_EQ(other.descriptor(), descriptor);
  EXPECT_TRUE(other.identity());
  other = PosixFile();
  struct stat status {};
  EXPECT_NE(::fstat(descriptor, &status), 0) << "closed";
}

}  // namespace
}  // namespace isosplat
