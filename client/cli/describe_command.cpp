#include "client/cli/describe_command.h"

#include <algorithm>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "client/cli/common/exit_codes.h"

namespace dcloc::cli {
namespace {

/// Subcommands with a name; option groups have none.
std::vector<const CLI::App*> CommandsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* sub) { return !sub->get_name().empty(); });
}

/// A command's own options and those of its groups.
std::vector<const CLI::Option*> OptionsOf(const CLI::App& app) {
  std::vector<const CLI::Option*> options = app.get_options();
  for (const CLI::App* group : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (!group->get_name().empty()) continue;
    const std::vector<const CLI::Option*> more = OptionsOf(*group);
    options.insert(options.end(), more.begin(), more.end());
  }
  return options;
}

/// Calls `visit(app, "map build")` for each command that can be run, with all of its names.
template <typename Visit>
void ForEachCommand(const CLI::App& app, const std::string& path, const Visit& visit) {
  visit(app, path);
  for (const CLI::App* sub : CommandsOf(app)) {
    ForEachCommand(*sub, absl::StrCat(path, path.empty() ? "" : " ", sub->get_name()), visit);
  }
}

std::vector<std::string> FlagsOf(const CLI::Option& option) {
  std::vector<std::string> flags;
  for (const std::string& name : option.get_lnames()) flags.push_back("--" + name);
  for (const std::string& name : option.get_snames()) flags.push_back("-" + name);
  return flags;
}

std::vector<std::string> WordsOf(const CLI::App& app) {
  std::vector<std::string> words;
  for (const CLI::App* sub : CommandsOf(app)) words.push_back(sub->get_name());
  for (const CLI::Option* option : OptionsOf(app)) {
    for (std::string& flag : FlagsOf(*option)) words.push_back(std::move(flag));
  }
  return words;
}

/// Whether a value follows the option.
bool TakesValue(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

std::string Roff(const std::string& text) {
  // A dot or quote at the start of a line would be a request, a dash a hyphen.
  std::vector<std::string> lines;
  for (const absl::string_view line : absl::StrSplit(text, '\n')) {
    std::string escaped = absl::StrReplaceAll(line, {{"\\", "\\e"}, {"-", "\\-"}});
    const bool is_request = !escaped.empty() && (escaped[0] == '.' || escaped[0] == '\'');
    lines.push_back(is_request ? "\\&" + escaped : escaped);
  }
  return absl::StrJoin(lines, "\n");
}

std::string OptionText(const CLI::Option& option) {
  std::vector<std::string> names = FlagsOf(option);
  if (names.empty()) names.push_back(option.get_name());
  std::string text = absl::StrCat(".TP\n\\fB", Roff(absl::StrJoin(names, ", ")), "\\fR");
  if (TakesValue(option)) absl::StrAppend(&text, " \\fI", Roff(option.get_type_name()), "\\fR");
  absl::StrAppend(&text, "\n", Roff(option.get_description()), ".");
  if (option.get_required()) absl::StrAppend(&text, " Required.");
  if (!option.get_default_str().empty()) {
    absl::StrAppend(&text, " Default: ", Roff(option.get_default_str()), ".");
  }
  if (!option.get_envname().empty()) {
    absl::StrAppend(&text, " Also from the environment: ", Roff(option.get_envname()), ".");
  }
  return text + "\n";
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
  ForEachCommand(app, "", [&](const CLI::App& /*command*/, const std::string& path) {
    if (path.empty()) return;
    const std::size_t space = path.rfind(' ');
    const bool is_top = space == std::string::npos;
    absl::StrAppend(&script, "      \"", is_top ? "" : path.substr(0, space), " ",
                    is_top ? path : path.substr(space + 1), "\") path='", path, "' ;;\n");
  });
  absl::StrAppend(&script, "    esac\n  done\n  local words\n  case \"$path\" in\n");
  ForEachCommand(app, "", [&](const CLI::App& command, const std::string& path) {
    absl::StrAppend(&script, "    '", path, "') words='", absl::StrJoin(WordsOf(command), " "),
                    "' ;;\n");
  });
  absl::StrAppend(
      &script,
      "  esac\n"
      "  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"${COMP_WORDS[COMP_CWORD]}\")\n"
      "  # Values are mostly files.\n"
      "  [ ${#COMPREPLY[@]} -gt 0 ] || compopt -o default\n"
      "}\n"
      "complete -F _",
      name, " ", name, "\n");
  return script;
}

std::string ManualPage(const CLI::App& app, const std::string& version) {
  const std::string& name = app.get_name();
  std::string page = absl::StrCat(".TH ", absl::AsciiStrToUpper(name), " 1 \"\" \"", name, " ",
                                  version, "\"\n.SH NAME\n", name, " \\- ",
                                  Roff(app.get_description()), "\n.SH SYNOPSIS\n\\fB", name,
                                  "\\fR \\fICOMMAND\\fR [\\fIOPTIONS\\fR]\n.SH COMMANDS\n");
  ForEachCommand(app, "", [&](const CLI::App& command, const std::string& path) {
    if (path.empty()) return;
    absl::StrAppend(&page, ".SS ", name, " ", Roff(path), "\n", Roff(command.get_description()),
                    "\n");
    for (const CLI::Option* option : OptionsOf(command))
      absl::StrAppend(&page, OptionText(*option));
    if (!command.get_footer().empty()) {
      absl::StrAppend(&page, ".PP\n.nf\n", Roff(command.get_footer()), "\n.fi\n");
    }
  });
  absl::StrAppend(&page,
                  ".SH EXIT STATUS\n0 for success, 1 when the command failed, 2 when the command "
                  "line makes no sense.\n");
  return page;
}

void AddDescribeCommands(CLI::App& app, const std::string& version, int& exit_code) {
  CLI::App* completion = app.add_subcommand(
      "completion", "Print a script that completes commands and options in bash");
  completion->footer("Example:\n  . <(dcloc completion)");
  completion->callback([&app, &exit_code] {
    absl::PrintF("%s", BashCompletion(app));
    exit_code = kSuccess;
  });
  CLI::App* manual = app.add_subcommand("manual", "Print the manual page, for man");
  manual->footer("Example:\n  dcloc manual | man -l -");
  manual->callback([&app, version, &exit_code] {
    absl::PrintF("%s", ManualPage(app, version));
    exit_code = kSuccess;
  });
}

}  // namespace dcloc::cli
