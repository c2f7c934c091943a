#include "native/cli/serving.h"

#include <fmt/format.h>

#include <csignal>
#include <memory>

#include "native/cli/command.h"
#include "native/cli/terminal.h"
#include "server/net/hand_over.h"
#include "server/net/service_manager.h"

namespace isosplat::cli {

std::filesystem::path find_page(const std::string& given) {
  if (!given.empty()) return given;
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return {};
  // build/release/native/cli/isosplat → build/page; libexec/isosplat/x86-64/isosplat and
  // bin/isosplat → share/isosplat/page
  for (const char* relative :
       {"../../../page", "../../../share/isosplat/page", "../share/isosplat/page"}) {
    const auto folder = (program.parent_path() / relative).lexically_normal();
    if (std::filesystem::exists(folder / "index.html", error)) return folder;
  }
  return {};
}

int serve_until_stopped(server::ServerOptions options, const std::string& query) {
  const std::shared_ptr<server::LogFile> log = options.log_file;
  if (options.web_root.empty()) {
    log->add(
        "note: the page has not been built: only the data is served. npm run build builds the "
        "page");
  }
  options.handle_signals = true;
  // The reader of the standard output may end: the server continues.
  std::signal(SIGPIPE, SIG_IGN);
  const auto output = server::LogFile::standard_output();
  auto server = server::Server::start(std::move(options));
  if (!server) return report(server.error());
  if (!(*server)->has_stores()) {
    log->add(
        "note: there is no store and no scene yet. The server notices them within a second after "
        "isosplat build has written them");
  }
  std::string url = (*server)->url();
  if (!query.empty()) url += "?" + query;
  output->add(fmt::format("Isosplat is ready: {}   (Ctrl-C stops it)", url));
  server::notify_service_manager("READY=1");
  server::notify_predecessor();
  (*server)->wait();
  return kSuccess;
}

}  // namespace isosplat::cli
