#include "client/cli/map/server/map_passes_command.h"

#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/cli/common/on_run.h"
#include "client/cli/common/terminal.h"
#include "client/cli/remote/answer_text.h"
#include "client/cli/remote/server_options.h"
#include "client/sdk/channel.h"
#include "client/sdk/pass_client.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

struct PassArguments {
  client::ChannelOptions server;
  std::string map;
  std::string identity;
  bool withdraw = false;
  bool list = false;
  bool json = false;
};

ordered_json PassJson(const v1::Pass& pass) {
  return {{"pass", pass.pass_id()},
          {"map", pass.map_name()},
          {"version", pass.map_version()},
          {"vehicle", pass.vehicle_pseudonym()},
          {"scan_count", pass.scan_count()},
          {"size_bytes", pass.size_bytes()},
          {"first_stamp_ns", pass.first_stamp_ns()},
          {"last_stamp_ns", pass.last_stamp_ns()},
          {"create_time", TimeText(pass.create_time())},
          {"expire_time", TimeText(pass.expire_time())}};
}

absl::Status ListPasses(const PassArguments& arguments) {
  const auto channel = client::MakeChannel(arguments.server);
  if (!channel.ok()) return channel.status();
  const auto passes = client::PassClient(*channel).List(arguments.map);
  if (!passes.ok()) return NamingServer(passes.status(), arguments.server);
  ordered_json list = ordered_json::array();
  std::vector<std::vector<std::string>> rows = {
      {"pass", "version", "vehicle", "scans", "size", "kept", "until"}};
  for (const v1::Pass& pass : *passes) {
    list.push_back(PassJson(pass));
    rows.push_back({pass.pass_id(), absl::StrFormat("%d", pass.map_version()),
                    pass.vehicle_pseudonym().substr(0, 8), absl::StrFormat("%d", pass.scan_count()),
                    FormatBytes(static_cast<double>(pass.size_bytes())),
                    TimeText(pass.create_time()), TimeText(pass.expire_time())});
  }
  absl::PrintF("%s", arguments.json ? list.dump(2) + "\n" : FormatTable(rows));
  return absl::OkStatus();
}

absl::Status ListConsents(client::PassClient& client, const PassArguments& arguments) {
  const auto consents = client.ListConsents();
  if (!consents.ok()) return consents.status();
  ordered_json list = ordered_json::array();
  std::vector<std::vector<std::string>> rows = {{"of", "name"}};
  for (const v1::PassConsent& consent : *consents) {
    const char* const kind = consent.has_map_name() ? "map" : "identity";
    const std::string name = consent.has_map_name() ? consent.map_name() : consent.identity_name();
    list.push_back({{"of", kind}, {"name", name}});
    rows.push_back({kind, name});
  }
  absl::PrintF("%s", arguments.json ? list.dump(2) + "\n" : FormatTable(rows));
  return absl::OkStatus();
}

absl::Status SetConsent(client::PassClient& client, const PassArguments& arguments) {
  v1::PassConsent consent;
  if (arguments.map.empty()) {
    consent.set_identity_name(arguments.identity);
  } else {
    consent.set_map_name(arguments.map);
  }
  const auto removed =
      client.SetConsent(consent, arguments.withdraw ? v1::PASS_CONSENT_STATE_WITHDRAWN
                                                    : v1::PASS_CONSENT_STATE_GIVEN);
  if (!removed.ok()) return removed.status();
  if (arguments.json) {
    const ordered_json json = {{"given", !arguments.withdraw}, {"removed_pass_count", *removed}};
    absl::PrintF("%s\n", json.dump(2));
  } else if (arguments.withdraw) {
    absl::PrintF("withdrawn; %d passes removed\n", *removed);
  } else {
    absl::PrintF("given\n");
  }
  return absl::OkStatus();
}

absl::Status Consent(const PassArguments& arguments) {
  const int named = (arguments.map.empty() ? 0 : 1) + (arguments.identity.empty() ? 0 : 1);
  if (named != (arguments.list ? 0 : 1)) {
    return absl::InvalidArgumentError("one of --map, --identity and --list must be given");
  }
  const auto channel = client::MakeChannel(arguments.server);
  if (!channel.ok()) return channel.status();
  client::PassClient client(*channel);
  return NamingServer(
      arguments.list ? ListConsents(client, arguments) : SetConsent(client, arguments),
      arguments.server);
}

void AddPasses(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<PassArguments>();
  CLI::App* app =
      map_command.add_subcommand("passes", "List the passes of vehicles that a server keeps");
  AddServerOptions(*app, arguments->server);
  app->add_option("--map", arguments->map, "Map that they are over")->required()->type_name("NAME");
  app->add_flag("--json", arguments->json, "Print as JSON");
  app->footer("Example:\n  dcloc map passes --server localhost:50051 --map town");
  OnRun(*app, arguments, exit_code, &ListPasses);
}

void AddConsent(CLI::App& map_command, int& exit_code) {
  auto arguments = std::make_shared<PassArguments>();
  CLI::App* app = map_command.add_subcommand(
      "pass-consent", "Consent to keeping passes over a map, or of an identity's vehicles");
  AddServerOptions(*app, arguments->server);
  app->add_option("--map", arguments->map, "Map whose passes may be kept")->type_name("NAME");
  app->add_option("--identity", arguments->identity,
                  "Name of a token or certificate whose vehicles' passes may be kept")
      ->type_name("NAME");
  app->add_flag("--withdraw", arguments->withdraw,
                "They may not any more; what was kept is removed");
  app->add_flag("--list", arguments->list, "List the consents that are given");
  app->add_flag("--json", arguments->json, "Print as JSON");
  app->footer(
      "A pass is kept only if its map and its identity both consent.\n"
      "Example:\n"
      "  dcloc map pass-consent --server localhost:50051 --map town\n"
      "  dcloc map pass-consent --server localhost:50051 --identity car-1\n"
      "  dcloc map pass-consent --server localhost:50051 --identity car-1 --withdraw");
  OnRun(*app, arguments, exit_code, &Consent);
}

}  // namespace

void AddMapPassesCommands(CLI::App& map_command, int& exit_code) {
  AddPasses(map_command, exit_code);
  AddConsent(map_command, exit_code);
}

}  // namespace dcloc::cli
