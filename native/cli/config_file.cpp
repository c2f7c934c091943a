#include "native/cli/config_file.h"

#include <fmt/format.h>

namespace isosplat::cli {
namespace {

constexpr const char* kOption = "--config";

/// Sets an option to the values of a line, unless the command line has set it.
void apply(CLI::App& command, const CLI::ConfigItem& item, const std::string& file) {
  const auto wrong = [&](const std::string& what) {
    return CLI::ValidationError(kOption, fmt::format("{}: {}", file, what));
  };
  if (!item.parents.empty()) {
    throw wrong(fmt::format("expected lines NAME = VALUE without sections, found the section '{}'",
                            item.parents.front()));
  }
  CLI::Option* option = command.get_option_no_throw("--" + item.name);
  if (!option) option = command.get_option_no_throw(item.name);
  if (!option || !option->get_configurable()) {
    throw wrong(fmt::format("expected the name of an option of {}, found '{}'", command.get_name(),
                            item.name));
  }
  if (option->count() > 0) return;
  if (option->get_expected_max() != 0) {
    for (const std::string& value : item.inputs) option->add_result(value);
    return;
  }
  const std::string value = item.inputs.size() == 1 ? item.inputs[0] : "";
  if (value != "true" && value != "false") {
    throw wrong(fmt::format("{}: expected true or false, found '{}'", item.name, value));
  }
  if (value == "true") option->add_result("true");
}

}  // namespace

void add_config_option(CLI::App& command) {
  command
      .add_option_function<std::string>(
          kOption,
          [&command](const std::string& file) {
            for (const CLI::ConfigItem& item : CLI::ConfigTOML().from_file(file)) {
              apply(command, item, file);
            }
          },
          "Read options from this file, which has lines NAME = VALUE. Options of the command line "
          "take precedence")
      ->configurable(false)
      ->check(CLI::ExistingFile)
      ->type_name("");
}

}  // namespace isosplat::cli
