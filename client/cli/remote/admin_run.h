#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "client/cli/common/on_run.h"
#include "client/cli/remote/server_options.h"
#include "client/sdk/admin_client.h"
#include "client/sdk/channel.h"

namespace dcloc::cli {

/// Makes a client of the server and runs `work` with it; an error of the connection names the
/// server.
absl::Status WithAdminClient(const client::ChannelOptions& server,
                             const std::function<absl::Status(client::AdminClient&)>& work);

/// The open session that `text` names: an id, the unique beginning of an id, or a vehicle with one
/// session. NotFound, or InvalidArgument with the candidates.
absl::StatusOr<v1::Session> FindSession(client::AdminClient& admin, const std::string& text);

/// Adds the command `name` to `parent`, with the options of a server and --json, which stand in
/// `arguments` as `server` and `json`; `run` says with which status it ends.
template <typename Arguments, typename Run>
CLI::App* AddAdminCommand(CLI::App& parent, const char* name, const char* description,
                          const std::shared_ptr<Arguments>& arguments, int& exit_code, Run run) {
  CLI::App* app = parent.add_subcommand(name, description);
  AddServerOptions(*app, arguments->server);
  app->add_flag("--json", arguments->json, "Print as JSON");
  OnRun(*app, arguments, exit_code, run);
  return app;
}

/// The same for a command that `run(admin, arguments)` carries out.
template <typename Arguments>
CLI::App* AddAdminCommand(CLI::App& parent, const char* name, const char* description,
                          const std::shared_ptr<Arguments>& arguments, int& exit_code,
                          absl::Status (*run)(client::AdminClient&, const Arguments&)) {
  return AddAdminCommand(
      parent, name, description, arguments, exit_code, [run](const Arguments& given) {
        return WithAdminClient(given.server,
                               [&](client::AdminClient& admin) { return run(admin, given); });
      });
}

}  // namespace dcloc::cli
