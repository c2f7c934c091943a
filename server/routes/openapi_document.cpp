#include "server/routes/openapi_document.h"

#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/routes/routes.h"

namespace isosplat::server {
namespace {

using Json = nlohmann::ordered_json;

Json reference(std::string_view kind, std::string_view name) {
  return {{"$ref", fmt::format("#/components/{}/{}", kind, name)}};
}

/// The operation's parameters in the path, in the query and in the header.
Json parameters_of(const Route& route, const Json& operation) {
  Json parameters = Json::array();
  std::string_view rest = route.pattern;
  for (size_t begin; (begin = rest.find('{')) != std::string_view::npos;) {
    rest.remove_prefix(begin + 1);
    std::string name(rest.substr(0, rest.find('}')));
    // Names and content ids of scenes are not those of volumes.
    if (route.kind() == ServedKind::scene) name = name == "name" ? "sceneName" : "sceneContent";
    parameters.push_back(reference("parameters", name));
  }
  for (const QueryParameter& parameter : route.parameters) {
    Json described = {{"name", parameter.name},
                      {"in", "query"},
                      {"description", parameter.description},
                      {"required", parameter.is_required},
                      {"schema", Json::parse(parameter.schema)}};
    if (!parameter.example.empty()) described["example"] = Json::parse(parameter.example);
    parameters.push_back(std::move(described));
  }
  for (const Json& field : operation.value("parameters", Json::array()))
    parameters.push_back(field);
  return parameters;
}

/// The responses that the operation states, and the common responses of all routes and of routes
/// with a volume or a scene.
Json responses_of(const Route& route, const Json& operation) {
  // Sorted by their status.
  std::map<std::string, Json> responses;
  for (const auto& [status, name] : {std::pair{"400", "Malformed"},
                                     {"403", "Forbidden"},
                                     {"414", "TargetTooLong"},
                                     {"429", "TooManyRequests"},
                                     {"431", "HeaderTooLarge"},
                                     {"503", "Busy"},
                                     {"505", "VersionNotSupported"}}) {
    responses[status] = reference("responses", name);
  }
  if (route.pattern.find("{name}") != std::string_view::npos) {
    for (const auto& [status, name] : {std::pair{"304", "NotModified"},
                                       {"401", "Unauthorized"},
                                       {"404", "NotFound"},
                                       {"412", "PreconditionFailed"},
                                       {"500", "Damaged"}}) {
      responses[status] = reference("responses", name);
    }
  }
  for (const auto& [status, response] : operation["responses"].items()) {
    responses[status] = response;
  }
  return responses;
}

std::string make_document() {
  Json parts = Json::parse(openapi_parts());
  Json paths = Json::object();
  for (const Route& route : routes()) {
    if (route.operation.empty()) continue;
    const Json& operation = parts["operations"][std::string(route.operation)];
    Json get = {{"operationId", route.operation}, {"summary", operation["summary"]}};
    Json parameters = parameters_of(route, operation);
    if (!parameters.empty()) get["parameters"] = std::move(parameters);
    get["responses"] = responses_of(route, operation);
    if (operation.contains("security")) get["security"] = operation["security"];
    paths[std::string(route.pattern)] = {{"get", std::move(get)}};
  }
  Json document = Json::object();
  for (auto& [key, value] : parts.items()) {
    if (key == "operations") {
      document["paths"] = std::move(paths);
    } else {
      document[key] = std::move(value);
    }
  }
  return document.dump(2) + "\n";
}

}  // namespace

const std::string& openapi_document() {
  static const std::string document = make_document();
  return document;
}

}  // namespace isosplat::server
