#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "server/routes/route_call.h"

namespace isosplat::server {

/// 400 invalid_argument.
Response invalid_argument(std::string_view message);

/// An ETag of the store's content. `version`: of the layout, for responses whose bytes are not
/// taken from the store as they are.
std::string etag_of(const StoreFile& store, std::string_view version = {});

// Handlers of the routes below /v1/volumes/{name}/{content}, whose bytes never change.

Response header_response(const RouteCall& call);
Response directory_page_response(const RouteCall& call);
Response chunk_response(const RouteCall& call);

/// The chunks of a level for an isovalue range, as frames.
Response chunks_response(const RouteCall& call);

/// The chunks of a list, as frames.
Response batch_response(const RouteCall& call);

/// The store file, or a range of it.
Response file_response(const RouteCall& call);

/// The picture beside the file of a store or a scene, if it shows this content.
Response picture_response(const RouteCall& call, const std::filesystem::path& file,
                          const std::string& content);

/// The picture beside the store, if it shows this content. Another picture of the same content has
/// the same URL, but another ETag.
Response thumbnail_response(const RouteCall& call);

}  // namespace isosplat::server
