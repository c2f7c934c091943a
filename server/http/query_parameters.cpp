#include "server/http/query_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace isosplat::server {
namespace {

/// "isovalue=a..b, level=L and optionally blocks=x.y.z,…".
std::string list_of(std::span<const QueryParameter> parameters) {
  std::string text;
  for (const bool is_required : {true, false}) {
    const char* separator = text.empty() ? "" : " and ";
    if (!is_required) separator = text.empty() ? "optionally " : " and optionally ";
    for (const QueryParameter& parameter : parameters) {
      if (parameter.is_required != is_required) continue;
      text += fmt::format("{}{}={}", separator, parameter.name, parameter.form);
      separator = ", ";
    }
  }
  return text;
}

}  // namespace

Result<void> check_query(const Target& target, std::span<const QueryParameter> parameters,
                         std::string_view subject) {
  const auto refused = [&](std::string_view problem, std::string_view name) {
    const std::string expected =
        parameters.empty() ? "no parameter"
                           : list_of(parameters) + ", each at most once, and no other parameter";
    return fail(Status::invalid_argument,
                fmt::format("{}: expected {}; {} {}", subject, expected, problem, quoted(name)));
  };
  for (auto item = target.query.begin(); item != target.query.end(); ++item) {
    const std::string& name = item->first;
    if (!std::ranges::count(parameters, name, &QueryParameter::name)) {
      return refused("found", name);
    }
    const auto is_same = [&](const auto& earlier) { return earlier.first == name; };
    if (std::any_of(target.query.begin(), item, is_same)) return refused("found twice:", name);
  }
  for (const QueryParameter& parameter : parameters) {
    if (parameter.is_required && !target.parameter(parameter.name)) {
      return refused("missing:", parameter.name);
    }
  }
  return {};
}

}  // namespace isosplat::server
