#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/routes/route_call.h"

namespace isosplat::server {

/// Which part of the list of volumes a client wants.
struct ListQuery {
  std::vector<std::string> words;  ///< with small letters a to z; each must occur in name or title
  uint32_t offset = 0;             ///< volumes to leave out at the beginning
  uint32_t limit = 100;            ///< the most volumes to return
};
inline constexpr uint32_t kMaxListLimit = 1000;

/// Parses query=, offset= and limit=. Errors: invalid_argument.
Result<ListQuery> parse_list_query(const Target& target);

/// The body of /v1/volumes: of the volumes that the client may read and that have all words of the
/// query, those from `offset` on, by name. Reads the headers that nobody has read yet, as far as
/// they are needed, in one turn at most kHeadersPerTurn; null if there are more, or if that must
/// wait, or would hold up the connection's thread.
std::optional<std::string> list_volumes(const RouteCall& call, const ListQuery& query);

}  // namespace isosplat::server
