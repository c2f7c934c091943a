#include "server/catalog/scene_json.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "server/catalog/volume_json.h"

namespace isosplat::server {
namespace {

using Json = nlohmann::ordered_json;

/// Lists leave out longer titles.
constexpr size_t kMaxTitle = 1024;

std::string json_text(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string url_of(std::string_view name) {
  return fmt::format("/v1/scenes/{}", name);
}

void add_facts(Json& json, const SceneFacts& facts) {
  json["contentId"] = facts.content;
  json["fileBytes"] = facts.bytes;
  json["layers"] = facts.layers;
  if (facts.steps > 0) json["steps"] = facts.steps;
  if (!facts.title.empty()) json["title"] = facts.title;
}

Json described(std::string_view name, const SceneFacts& facts) {
  Json json = {{"name", name}, {"url", url_of(name)}};
  add_facts(json, facts);
  if (facts.has_thumbnail) {
    json["thumbnail"] = fmt::format("{}/{}/thumbnail.webp", url_of(name), facts.content);
  }
  return json;
}

}  // namespace

SceneFacts facts_of(const Scene& scene, std::string content, uint64_t bytes) {
  SceneFacts facts;
  facts.content = std::move(content);
  facts.bytes = bytes;
  if (scene.name.size() <= kMaxTitle) facts.title = scene.name;
  facts.layers = scene.layers.size();
  facts.steps = scene.time ? scene.time->values.size() : 0;
  return facts;
}

StoreSummary scene_summary(const std::string& name, const SceneFacts& facts) {
  StoreSummary summary;
  summary.content = facts.content;
  summary.title = small_letters(facts.title);
  summary.list_item = json_text(described(name, facts));
  return summary;
}

StoreSummary scene_summary(const std::string& name, Error error) {
  const Json json = {
      {"name", name},
      {"url", url_of(name)},
      {"error", {{"status", status_name(error.status)}, {"message", error.message}}}};
  StoreSummary summary;
  summary.list_item = json_text(json);
  summary.error = std::move(error);
  return summary;
}

std::string published_scene_json(std::string_view name, std::string_view file,
                                 const SceneFacts& facts, std::string_view thumbnail) {
  Json json = {{"name", name}, {"file", file}};
  add_facts(json, facts);
  if (!thumbnail.empty()) json["thumbnail"] = thumbnail;
  return json_text(json);
}

std::string scene_json(std::string_view name, const SceneFacts& facts) {
  Json json = described(name, facts);
  json["urls"] = {{"bootstrap", url_of(name) + "/bootstrap"},
                  {"file", fmt::format("{}/{}/file", url_of(name), facts.content)}};
  return json_text(json) + "\n";
}

}  // namespace isosplat::server
