#include "server/volume_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "server/summaries.h"
#include "server/volume_json.h"

namespace isosplat {
namespace {

bool has_word(std::string_view text, std::string_view word) {
  return text.find(word) != std::string_view::npos;
}

struct ListProgress : CatalogProgress {
  using CatalogProgress::CatalogProgress;

  uint64_t total = 0, bytes = 0;
  std::string items;
};

/// Whether an entry has all words in its name or its title; no value if its title is not known yet.
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

/// Adds the next volumes. Returns false if it cannot go on in this turn.
bool add_volumes(const RouteCall& call, const ListQuery& query, ListProgress& list) {
  Summaries summaries(call);
  for (; list.next != list.catalog->end(); ++list.next) {
    const CatalogEntry& entry = *list.next->second;
    if (!call.may_read(entry)) continue;
    if (!query.words.empty()) {
      const std::optional<bool> is_match = matches(summaries, entry, query.words);
      if (!is_match) return false;
      if (!*is_match) continue;
    }
    if (list.total >= query.offset && list.total - query.offset < query.limit) {
      const auto summary = summaries.of(entry);
      if (!summary) return false;
      list.items += list.items.empty() ? "\n" : ",\n";
      list.items += summary->list_item;
    }
    if (entry.identity) list.bytes += entry.identity->bytes;
    ++list.total;
  }
  return true;
}

}  // namespace

Result<ListQuery> parse_list_query(const Target& target) {
  Parameters parameters(target);
  const auto text = parameters.get("query");
  const auto offset = parameters.get("offset");
  const auto limit = parameters.get("limit");
  if (!parameters.are_valid()) {
    return fail(Status::invalid_argument,
                "volumes: expected query=, offset= and limit=, each at most once, and no other "
                "parameter");
  }
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

std::optional<std::string> list_volumes(const RouteCall& call, const ListQuery& query) {
  // A long list takes milliseconds: other requests of this thread do not wait for it.
  constexpr size_t kShortList = 1000;
  if (call.no_wait && call.catalog->size() > kShortList) {
    call.no_wait->needs_disk = true;
    return std::nullopt;
  }
  std::unique_ptr<WorkTurn::Progress> own;
  auto& list = progress_of<ListProgress>(call, own);
  if (!add_volumes(call, query, list)) return std::nullopt;
  return fmt::format("{{\"total\":{},\"fileBytes\":{},\"offset\":{},\"volumes\":[{}]}}\n",
                     list.total, list.bytes, query.offset, list.items);
}

}  // namespace isosplat
