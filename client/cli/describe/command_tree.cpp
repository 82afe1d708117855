#include "client/cli/describe/command_tree.h"

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace dcloc::cli {
namespace {

using Visit = std::function<void(const CLI::App&, const std::string&)>;

void VisitBelow(const CLI::App& app, const std::string& path, const Visit& visit) {
  visit(app, path);
  for (const CLI::App* sub : CommandsOf(app)) {
    VisitBelow(*sub, absl::StrCat(path, path.empty() ? "" : " ", sub->get_name()), visit);
  }
}

// The last one of a command's names: "build" of "map build".
std::string LastName(const std::string& path) {
  const std::size_t space = path.rfind(' ');
  return space == std::string::npos ? path : path.substr(space + 1);
}

// All but the last one: "map" of "map build", "" of "map".
std::string ParentPath(const std::string& path) {
  const std::size_t space = path.rfind(' ');
  return space == std::string::npos ? "" : path.substr(0, space);
}

}  // namespace

std::vector<const CLI::App*> CommandsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* sub) { return !sub->get_name().empty(); });
}

std::vector<const CLI::Option*> OptionsOf(const CLI::App& app) {
  std::vector<const CLI::Option*> options = app.get_options();
  for (const CLI::App* group : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (!group->get_name().empty()) continue;
    const std::vector<const CLI::Option*> more = OptionsOf(*group);
    options.insert(options.end(), more.begin(), more.end());
  }
  return options;
}

void ForEachCommand(const CLI::App& app, const Visit& visit) { VisitBelow(app, "", visit); }

std::vector<std::string> FlagsOf(const CLI::Option& option) {
  std::vector<std::string> flags;
  for (const std::string& name : option.get_lnames()) flags.push_back("--" + name);
  for (const std::string& name : option.get_snames()) flags.push_back("-" + name);
  return flags;
}

bool TakesValue(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

std::vector<std::string> ChoicesOf(const CLI::Option& option) {
  // CLI11 writes the values of a check into the type: "TEXT:{none,bz2,lz4}".
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find('{');
  const std::size_t end = type.find('}');
  if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
  return absl::StrSplit(type.substr(begin + 1, end - begin - 1), ',', absl::SkipEmpty());
}

void ForEachChoice(
    const CLI::App& app,
    const std::function<void(const std::string&, const std::vector<std::string>&)>& visit) {
  ForEachCommand(app, [&](const CLI::App& command, const std::string& path) {
    for (const CLI::Option* option : OptionsOf(command)) {
      const std::vector<std::string> choices = ChoicesOf(*option);
      if (choices.empty()) continue;
      for (const std::string& flag : FlagsOf(*option)) {
        visit(absl::StrCat(path, " ", flag), choices);
      }
    }
  });
}

std::string PathCases(const CLI::App& app, const std::string& variable) {
  std::string cases;
  ForEachCommand(app, [&](const CLI::App& /*command*/, const std::string& path) {
    if (path.empty()) return;
    absl::StrAppend(&cases, "      '", ParentPath(path), " ", LastName(path), "') ", variable, "='",
                    path, "' ;;\n");
  });
  return cases;
}

}  // namespace dcloc::cli
