#include "server/catalog/keep_summary.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>

namespace isosplat::server {
namespace {

/// Whether the error is temporary, so that it must not be kept.
bool is_passing(const Error& error) {
  return error.status == Status::io_error || error.status == Status::out_of_memory;
}

}  // namespace

bool keep_summary(const CatalogEntry& entry, const std::shared_ptr<const StoreSummary>& summary,
                  const Error* cause, const std::function<void(std::string_view)>& log) {
  const bool is_passing_error = summary->error && is_passing(*summary->error);
  const bool is_news = is_passing_error ? entry.summary.set_passing(summary->error->message)
                                        : entry.summary.set(summary);
  if (!is_news) return false;
  const std::string_view word = word_of(entry.kind);
  if (summary->error) {
    log(fmt::format("{} {} is not served: {}", word, entry.name,
                    (cause ? *cause : *summary->error).message));
  } else if (!entry.content_before.empty() && entry.content_before != summary->content) {
    log(
        fmt::format("{} {}: {} has another content now: {} in place of {}: tokens and links for "
                    "this name admit to it",
                    word, entry.name, entry.path.string(), summary->content, entry.content_before));
  } else if (!entry.is_one_of_many) {
    log(fmt::format("{} {}: {}, content {}", word, entry.name, entry.path.string(),
                    summary->content));
  }
  return true;
}

bool has_descriptors() {
  const int file = ::open("/", O_PATH | O_CLOEXEC);
  if (file >= 0) ::close(file);
  return file >= 0 || (errno != EMFILE && errno != ENFILE);
}

}  // namespace isosplat::server
