// The logs of the server: no error of a log delays a request or ends the program, and no file name
// can add a line to a log.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <sstream>

#include "server/http/printable_text.h"
#include "server/log/log_file.h"
#include "tests/server/server_fixture.h"

namespace isosplat::server::test {
namespace {

TEST(PrintableText, EscapesCharactersThatCouldChangeALine) {
  EXPECT_EQ(printable_text("volume Müller 張: /a b/c.isosplat"),
            "volume Müller 張: /a b/c.isosplat");
  EXPECT_EQ(printable_text("a\nb\r\t\x1b[31m\x7f"), "a\\x0ab\\x0d\\x09\\x1b[31m\\x7f");
  EXPECT_EQ(printable_text("\\x0a"), "\\x5cx0a") << "escapes in the text are escaped, too";
  EXPECT_EQ(printable_text("\xff\xc3"), "\\xff\\xc3");
  EXPECT_EQ(printable_text("\xc2\x9b"
                           "31m"),
            "\\xc2\\x9b31m")
      << "CSI of 8 bits";
  EXPECT_EQ(printable_text("\xe2\x80\xae"
                           "gnp.exe"),
            "\\xe2\\x80\\xaegnp.exe");
  EXPECT_EQ(printable_text("\xe2\x80\xa8\xe2\x81\xa6"), "\\xe2\\x80\\xa8\\xe2\\x81\\xa6");
  EXPECT_EQ(printable_text("\xe2\x80\x94\xe2\x81\xaa"), "\xe2\x80\x94\xe2\x81\xaa");
  EXPECT_EQ(printable_text(std::string_view("\0x", 2)), "\\x00x");
}

/// A named pipe, and its reader.
struct Pipe {
  explicit Pipe(const std::filesystem::path& its_path) : path(its_path) {
    EXPECT_EQ(::mkfifo(path.c_str(), 0600), 0);
    reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  }
  ~Pipe() { close_reader(); }
  void close_reader() {
    if (reader >= 0) ::close(reader);
    reader = -1;
  }
  std::string read() const {
    std::string text(1 << 16, '\0');
    const ssize_t count = ::read(reader, text.data(), text.size());
    text.resize(count > 0 ? static_cast<size_t>(count) : 0);
    return text;
  }
  const std::filesystem::path path;
  int reader = -1;
};

class Logs : public ServerTest {
 protected:
  /// The lines of a log that were dropped, as /metrics has them.
  uint64_t dropped(const std::string& log) {
    const std::string text = get(port(), "/metrics").body;
    const std::string name = "\nisosplat_log_lines_dropped_total{log=\"" + log + "\"} ";
    const size_t at = text.find(name);
    if (at == text.npos) return 0;
    return std::stoull(text.substr(at + name.size()));
  }

  /// Sends requests until lines of the access log are dropped. All of them must get a response.
  void request_until_dropped() {
    const std::string target = "/none?" + std::string(4000, 'x');
    Client client(port());
    EXPECT_TRUE(eventually([&] {
      for (int i = 0; i < 100; ++i) EXPECT_EQ(client.request("GET", target).status, 404);
      return dropped("access") > 0;
    }));
  }
};

TEST_F(Logs, AFullDiskDropsLinesAndStopsNobody) {
  options.access_log_file = "/dev/full";
  options.log_file = *LogFile::open("/dev/full");
  start();
  for (int i = 0; i < 3; ++i) EXPECT_EQ(get(port(), "/healthz").status, 200);
  EXPECT_TRUE(eventually([&] { return dropped("access") >= 3 && dropped("server") >= 1; }));
}

TEST_F(Logs, APipeWithoutAReaderDropsLinesAndEndsNobody) {
  Pipe access(folder.path() / "access"), log(folder.path() / "log");
  options.access_log_file = access.path;
  options.log_file = *LogFile::open(log.path);
  start();
  EXPECT_EQ(get(port(), "/healthz").status, 200);
  EXPECT_TRUE(eventually([&] { return access.read().find("/healthz") != std::string::npos; }));
  access.close_reader();
  log.close_reader();
  write_file(folder.path() / "beta.isosplat", alpha.file);
  EXPECT_TRUE(eventually([&] { return dropped("access") >= 1 && dropped("server") >= 1; }));
}

TEST_F(Logs, APipeThatBlocksDelaysNoRequestAndNoStop) {
  Pipe access(folder.path() / "access"), log(folder.path() / "log");
  options.access_log_file = access.path;
  options.log_file = *LogFile::open(log.path);
  start();
  request_until_dropped();
  EXPECT_EQ(get(port(), content("header")).status, 200);
  server.reset();  // must return
}

TEST_F(Logs, ABlockingWriteDelaysNoStop) {
  // A standard error that is a pipe without O_NONBLOCK.
  int ends[2];
  ASSERT_EQ(::pipe2(ends, O_CLOEXEC), 0);
  const int saved = ::dup(STDERR_FILENO);
  {
    const auto log = LogFile::standard_error();
    ::dup2(ends[1], STDERR_FILENO);
    const std::string line(1000, 'x');
    for (int i = 0; i < 3000; ++i) log->add(line);
    EXPECT_GT(log->dropped(), 0u);
  }
  ::dup2(saved, STDERR_FILENO);
  ::close(saved);
  ::close(ends[0]);  // ends the write
  ::close(ends[1]);
}

TEST_F(Logs, LinesThatWereNotWrittenLeaveNoHalfLine) {
  Pipe pipe(folder.path() / "log");
  const auto log = std::shared_ptr<LogFile>(*LogFile::open(pipe.path));
  const std::string line(3000, 'x');
  for (int i = 0; i < 40; ++i) log->add(line);
  std::string text;
  size_t lines = 0;
  EXPECT_TRUE(eventually([&] {
    text += pipe.read();
    lines = static_cast<size_t>(std::ranges::count(text, '\n'));
    return lines == 40;
  })) << lines;
  std::istringstream stream(text);
  for (std::string each; std::getline(stream, each);) EXPECT_EQ(each, line);
}

TEST_F(Logs, NamesOfFilesCannotWriteLines) {
  const std::string evil = "x\n2026-11-22 volume fake: all is well\x1b[2J";
  write_file(folder.path() / (evil + ".isosplat"), alpha.file);
  write_file(folder.path() / ("broken\r" + evil + ".isosplat"), "no store");
  start();
  EXPECT_TRUE(eventually([&] {
    return log_mentions("x\\x0a2026-11-22 volume fake: all is well\\x1b[2J.isosplat, content") &&
           log_mentions("broken\\x0dx");
  }));
  EXPECT_FALSE(log_mentions("\n"));
  EXPECT_FALSE(log_mentions("\x1b"));
  std::filesystem::create_directory(folder.path() / "f\ne");
  write_file(folder.path() / "f\ne" / "a.isosplat", alpha.file);
  std::filesystem::remove(folder.path() / (evil + ".isosplat"));
  EXPECT_TRUE(will_log("was removed"));
  EXPECT_FALSE(log_mentions("\n"));
}

}  // namespace
}  // namespace isosplat::server::test
