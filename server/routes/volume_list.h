#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/routes/route_call.h"

namespace isosplat::server {

/// The part of the list of volumes or scenes that a client requests.
struct ListQuery {
  std::vector<std::string> words;  ///< with small letters a to z; each must occur in name or title
  uint32_t offset = 0;             ///< number to skip
  uint32_t limit = 100;            ///< maximum number to return
};
inline constexpr uint32_t kMaxListLimit = 1000;

/// Parses query=, offset= and limit=. Errors: invalid_argument.
Result<ListQuery> parse_list_query(const Target& target);

/// The body of /v1/volumes or /v1/scenes. Of the volumes or scenes that the client may read and
/// that match all words of the query, it has those from `offset` on, by name. Reads the headers
/// that are needed and have not been read yet, within the limit of a turn (Summaries). Null if
/// there are more, or if this must wait, or would block the connection's thread.
std::optional<std::string> list_files(const RouteCall& call, ServedKind kind,
                                      const ListQuery& query);

}  // namespace isosplat::server
