#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "client/cli/describe/command_tree.h"
#include "client/cli/describe/completion.h"

namespace dcloc::cli {
namespace {

std::string WordsOf(const CLI::App& app) {
  std::vector<std::string> words;
  for (const CLI::App* sub : CommandsOf(app)) words.push_back(sub->get_name());
  for (const CLI::Option* option : OptionsOf(app)) {
    for (std::string& flag : FlagsOf(*option)) words.push_back(std::move(flag));
  }
  return absl::StrJoin(words, " ");
}

/// A line each of: "map build --dataset") words='nuscenes rosbag' ;;
std::string ChoiceCases(const CLI::App& app) {
  std::string cases;
  ForEachChoice(app, [&](const std::string& flag, const std::vector<std::string>& choices) {
    absl::StrAppend(&cases, "    '", flag, "') words='", absl::StrJoin(choices, " "), "' ;;\n");
  });
  return cases;
}

}  // namespace

std::string BashCompletion(const CLI::App& app) {
  const std::string& name = app.get_name();
  std::string script =
      absl::StrCat("# Completes ", name, " in bash; made by ", name, " completion.\n_", name,
                   "() {\n"
                   "  local word path='' i\n"
                   "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
                   "    word=${COMP_WORDS[i]}\n"
                   "    case \"$path $word\" in\n");
  absl::StrAppend(&script, PathCases(app, "path"),
                  "    esac\n  done\n  local words\n  case \"$path\" in\n");
  ForEachCommand(app, [&](const CLI::App& command, const std::string& path) {
    absl::StrAppend(&script, "    '", path, "') words='", WordsOf(command), "' ;;\n");
  });
  absl::StrAppend(
      &script,
      "  esac\n"
      "  case \"$path ${COMP_WORDS[COMP_CWORD - 1]}\" in\n",
      ChoiceCases(app),
      "  esac\n"
      "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"${COMP_WORDS[COMP_CWORD]}\")\n"
      "  # Values are mostly files.\n"
      "  [ ${#COMPREPLY[@]} -gt 0 ] || compopt -o default\n"
      "}\n"
      "complete -F _",
      name, " ", name, "\n");
  return script;
}

}  // namespace dcloc::cli
