#include "client/cli/describe/describe_command.h"

#include <memory>

#include "absl/strings/str_format.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/describe/completion.h"
#include "client/cli/describe/manual_page.h"

namespace dcloc::cli {

void AddDescribeCommands(CLI::App& app, const std::string& version, int& exit_code) {
  CLI::App* completion = app.add_subcommand(
      "completion", "Print a script that completes commands, options and values in a shell");
  auto shell = std::make_shared<std::string>("bash");
  completion->add_option("shell", *shell, "The shell")
      ->check(CLI::IsMember({"bash", "zsh"}))
      ->capture_default_str();
  completion->footer(
      "Examples:\n"
      "  . <(dcloc completion)\n"
      "  . <(dcloc completion zsh)    # after compinit");
  completion->callback([&app, shell, &exit_code] {
    absl::PrintF("%s", *shell == "zsh" ? ZshCompletion(app) : BashCompletion(app));
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
