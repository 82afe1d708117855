#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "client/cli/describe/command_tree.h"
#include "client/cli/describe/completion.h"

namespace dcloc::cli {
namespace {

/// 'build:Make a map', as _describe takes it; the first line of a description.
std::string Entry(const std::string& word, const std::string& description) {
  const std::string line = std::vector<std::string>(absl::StrSplit(description, '\n')).front();
  return absl::StrCat("'", absl::StrReplaceAll(word, {{":", "\\:"}}), ":",
                      absl::StrReplaceAll(line, {{"'", "'\\''"}}), "' ");
}

std::string CommandCase(const CLI::App& command, const std::string& path) {
  std::string entry = absl::StrCat("    '", path, "')\n      commands=(");
  for (const CLI::App* sub : CommandsOf(command)) {
    absl::StrAppend(&entry, Entry(sub->get_name(), sub->get_description()));
  }
  absl::StrAppend(&entry, ")\n      options=(");
  for (const CLI::Option* option : OptionsOf(command)) {
    for (const std::string& flag : FlagsOf(*option)) {
      absl::StrAppend(&entry, Entry(flag, option->get_description()));
    }
  }
  return absl::StrCat(entry, ")\n      ;;\n");
}

std::string ValueCases(const CLI::App& app) {
  std::string cases;
  ForEachChoice(app, [&](const std::string& flag, const std::vector<std::string>& choices) {
    absl::StrAppend(&cases, "    '", flag, "') values=(");
    for (const std::string& choice : choices) absl::StrAppend(&cases, Entry(choice, ""));
    absl::StrAppend(&cases, ") ;;\n");
  });
  return cases;
}

}  // namespace

std::string ZshCompletion(const CLI::App& app) {
  const std::string& name = app.get_name();
  std::string script = absl::StrCat("#compdef ", name, "\n# Completes ", name, " in zsh; made by ",
                                    name, " completion zsh.\n_", name,
                                    "() {\n"
                                    "  local place='' i\n"
                                    "  local -a commands options values\n"
                                    "  for ((i = 2; i < CURRENT; ++i)); do\n"
                                    "    case \"$place ${words[i]}\" in\n");
  absl::StrAppend(&script, PathCases(app, "place"), "    esac\n  done\n  case \"$place\" in\n");
  ForEachCommand(app, [&](const CLI::App& command, const std::string& path) {
    absl::StrAppend(&script, CommandCase(command, path));
  });
  absl::StrAppend(&script, "  esac\n  case \"$place ${words[CURRENT - 1]}\" in\n", ValueCases(app),
                  "  esac\n"
                  "  if ((${#values})); then _describe value values; return; fi\n"
                  "  if [[ ${words[CURRENT]} == -* ]]; then _describe option options; return; fi\n"
                  "  if ((${#commands})); then _describe command commands; return; fi\n"
                  "  _files\n"
                  "}\n"
                  "if [[ ${funcstack[1]} == _",
                  name, " ]]; then _", name, " \"$@\"; else compdef _", name, " ", name, "; fi\n");
  return script;
}

}  // namespace dcloc::cli
