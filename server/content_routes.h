#pragma once

#include <memory>
#include <span>
#include <string>

#include "server/message.h"
#include "server/router.h"
#include "server/target.h"
#include "shared/store_file/store_file.h"

namespace isosplat {

/// Answers what lies below /v1/volumes/{name}/{content}: bytes that never change under their URL.
/// `rest`: the segments after {content}; `query`: as in Target.
Response content_answer(const Request& request, std::shared_ptr<const StoreFile> store,
                        std::span<const std::string> rest, const Target& target,
                        const RouterLimits& limits);

}  // namespace isosplat
