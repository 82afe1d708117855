#include "client/cli/describe/manual_page.h"

#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "client/cli/describe/command_tree.h"

namespace dcloc::cli {
namespace {

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

std::string ManualPage(const CLI::App& app, const std::string& version) {
  const std::string& name = app.get_name();
  std::string page = absl::StrCat(".TH ", absl::AsciiStrToUpper(name), " 1 \"\" \"", name, " ",
                                  version, "\"\n.SH NAME\n", name, " \\- ",
                                  Roff(app.get_description()), "\n.SH SYNOPSIS\n\\fB", name,
                                  "\\fR \\fICOMMAND\\fR [\\fIOPTIONS\\fR]\n.SH COMMANDS\n");
  ForEachCommand(app, [&](const CLI::App& command, const std::string& path) {
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
                  "line makes no sense, 3 when doctor warns.\n");
  return page;
}

}  // namespace dcloc::cli
