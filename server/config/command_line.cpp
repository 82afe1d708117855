#include "server/config/command_line.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"

namespace dcloc::server {
namespace {

constexpr char kDescription[] = "dcloc-server: localizes vehicles in radar maps, over gRPC.";
constexpr char kFooter[] = R"(
Examples:
  dcloc-server --data ./store
      listens on 127.0.0.1:50051 for clients on this machine
  dcloc-server --data ./store --listen 0.0.0.0:50051 --tls-cert server.pem --tls-key server.key
      serves other machines, encrypted
  dcloc-server --data ./store --listen 0.0.0.0:50051 --tls-cert server.pem --tls-key server.key \
      --tls-client-ca fleet-ca.pem
      only serves clients with a certificate of the fleet's authority
  dcloc-server --config server.json --check-config
      says what is wrong with the settings, without starting; a running server takes changed
      limits and log level from the file on SIGHUP
  dcloc-server token create --data ./store --name ops --role admin
      makes the first identity; from then on every caller needs one (see token --help)
  dcloc-server store backup --data ./store --to /backup/dcloc
      copies the store of a running server; check, repair and restore: see store --help
  dcloc-server --config server.json --log-level debug
      takes a JSON file with the same keys ("tls_cert" for --tls-cert); flags go before it)";

struct GivenFlag {
  const ConfigField* field;
  CLI::Option* option;
};

/// Of a setting that was renamed, both names.
std::string FlagNames(const ConfigField& field) {
  std::string name = absl::StrCat("--", field.key);
  if (*field.former_key != '\0') absl::StrAppend(&name, ",--", field.former_key);
  std::ranges::replace(name, '_', '-');
  return name;
}

CLI::Option* AddFlag(CLI::App& app, const ConfigField& field, ServerConfig& values) {
  return std::visit(
      [&](auto member) {
        auto& value = values.*member;
        if constexpr (std::is_same_v<decltype(value), bool&>) {
          return app.add_flag(FlagNames(field), value, field.help);
        } else {
          return app.add_option(FlagNames(field), value, field.help)
              ->type_name(field.type_name)
              ->capture_default_str();
        }
      },
      field.member);
}

}  // namespace

absl::StatusOr<CommandLine> ParseCommandLine(int argc, const char* const* argv) {
  CLI::App app(kDescription);
  app.footer(kFooter);
  app.set_version_flag("--version", DCLOC_VERSION);
  std::string config_file;
  app.add_option("--config", config_file, "JSON file of the same settings")->type_name("FILE");
  CommandLine command_line;
  app.add_flag("--check-config", command_line.check_config,
               "only check the settings and the files that they name; exit code 0 if all is well");
  ServerConfig flags;
  std::vector<GivenFlag> options;
  for (const ConfigField& field : ConfigFields()) {
    options.push_back({&field, AddFlag(app, field, flags)});
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return CommandLine{.print = app.help(), .config = {}};
  } catch (const CLI::CallForVersion&) {
    return CommandLine{.print = absl::StrCat("dcloc-server ", DCLOC_VERSION, "\n"), .config = {}};
  } catch (const CLI::ParseError& error) {
    return absl::InvalidArgumentError(error.what());
  }
  if (!config_file.empty()) {
    if (absl::Status status = ReadConfigFile(config_file, &command_line.config); !status.ok()) {
      return status;
    }
  }
  for (const GivenFlag& given : options) {
    if (given.option->count() > 0) TakeField(*given.field, flags, &command_line.config);
  }
  if (absl::Status status = Validate(command_line.config); !status.ok()) return status;
  return command_line;
}

}  // namespace dcloc::server
