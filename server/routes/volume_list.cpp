#include "server/routes/volume_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "server/catalog/volume_json.h"
#include "server/routes/summaries.h"

namespace isosplat::server {
namespace {

bool has_word(std::string_view text, std::string_view word) {
  return text.find(word) != std::string_view::npos;
}

/// The progress of a list. Entries before `next` are done.
struct ListProgress : WorkTurn::Progress {
  std::shared_ptr<const VolumeView> view;
  size_t next = 0;
  uint64_t total = 0, bytes = 0;
  std::string items;
};

/// Whether the name or the title of an entry contains all words; no value if the title is not known
/// yet.
std::optional<bool> matches(Summaries& summaries, const CatalogEntry& entry,
                            const std::vector<std::string>& words) {
  const std::string name = small_letters(entry.name);
  const auto is_in_name = [&](const std::string& word) { return has_word(name, word); };
  if (std::ranges::all_of(words, is_in_name)) return true;
  const auto summary = summaries.of(entry);
  if (!summary) return std::nullopt;
  return std::ranges::all_of(words, [&](const std::string& word) {
    return is_in_name(word) || has_word(summary->title, word);
  });
}

/// Adds an entry's item. Returns false if it cannot be read in this turn.
bool add_item(Summaries& summaries, const CatalogEntry& entry, ListProgress& list) {
  const auto summary = summaries.of(entry);
  if (!summary) return false;
  list.items += list.items.empty() ? "\n" : ",\n";
  list.items += summary->list_item;
  return true;
}

/// Adds the volumes of a list without words; examines no other volumes. Returns false if the list
/// needs another turn.
bool add_part(const RouteCall& call, const ListQuery& query, ListProgress& list) {
  Summaries summaries(call);
  const auto& entries = list.view->entries;
  list.total = entries.size();
  list.bytes = list.view->bytes;
  list.next = std::max<size_t>(list.next, query.offset);
  const size_t end = std::min<size_t>(entries.size(), size_t{query.offset} + query.limit);
  for (; list.next < end; ++list.next) {
    if (!add_item(summaries, *entries[list.next], list)) return false;
  }
  return true;
}

/// Adds the next volumes that match the words. Returns false if the list needs another turn.
bool add_matches(const RouteCall& call, const ListQuery& query, ListProgress& list) {
  constexpr size_t kSearchedPerTurn = 5000;
  Summaries summaries(call);
  const auto& entries = list.view->entries;
  for (size_t searched = 0; list.next < entries.size(); ++list.next, ++searched) {
    if (call.turn && searched == kSearchedPerTurn) {
      call.turn->is_unfinished = true;
      return false;
    }
    const CatalogEntry& entry = *entries[list.next];
    const std::optional<bool> is_match = matches(summaries, entry, query.words);
    if (!is_match) return false;
    if (!*is_match) continue;
    const bool is_within = list.total >= query.offset && list.total - query.offset < query.limit;
    if (is_within && !add_item(summaries, entry, list)) return false;
    if (entry.identity) list.bytes += entry.identity->bytes;
    ++list.total;
  }
  return true;
}

}  // namespace

Result<ListQuery> parse_list_query(const Target& target) {
  const auto text = target.parameter("query");
  const auto offset = target.parameter("offset");
  const auto limit = target.parameter("limit");
  ListQuery query;
  if (offset) {
    const auto number = parse_index(*offset);
    if (!number) return fail(Status::invalid_argument, "offset: expected a number");
    query.offset = *number;
  }
  if (limit) {
    const auto number = parse_index(*limit, kMaxListLimit);
    if (!number || *number == 0) {
      return fail(Status::invalid_argument,
                  fmt::format("limit: expected a number from 1 to {}", kMaxListLimit));
    }
    query.limit = *number;
  }
  std::string words = small_letters(text.value_or(std::string_view()));
  for (std::string_view rest = words; !rest.empty();) {
    const std::string_view word = rest.substr(0, rest.find(' '));
    rest.remove_prefix(std::min(word.size() + 1, rest.size()));
    if (!word.empty()) query.words.emplace_back(word);
  }
  constexpr size_t kMaxWords = 32;
  if (query.words.size() > kMaxWords) {
    return fail(Status::invalid_argument, fmt::format("query: expected at most {} words, found {}",
                                                      kMaxWords, query.words.size()));
  }
  return query;
}

std::optional<std::string> list_files(const RouteCall& call, ServedKind kind,
                                      const ListQuery& query) {
  const auto& [catalog, views, counts] = call.files(kind);
  // Iterating over many files takes milliseconds, so other requests of this thread must not wait
  // for it.
  constexpr size_t kFew = 1000;
  const bool are_many = catalog->size() > kFew;
  std::unique_ptr<WorkTurn::Progress> own;
  std::unique_ptr<WorkTurn::Progress>& progress = call.turn ? call.turn->progress : own;
  if (!progress) {
    auto begun = std::make_unique<ListProgress>();
    begun->view = views.find(catalog, call.grant);
    if (call.no_wait && are_many && (!begun->view || !query.words.empty())) {
      call.no_wait->needs_disk = true;
      return std::nullopt;
    }
    if (!begun->view) begun->view = views.make(catalog, call.grant);
    progress = std::move(begun);
  }
  auto& list = static_cast<ListProgress&>(*progress);
  if (!(query.words.empty() ? add_part : add_matches)(call, query, list)) return std::nullopt;
  return fmt::format("{{\"total\":{},\"fileBytes\":{},\"offset\":{},\"{}s\":[{}]}}\n", list.total,
                     list.bytes, query.offset, word_of(kind), list.items);
}

}  // namespace isosplat::server
