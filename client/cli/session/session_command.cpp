#include "client/cli/session/session_command.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/stop_signals.h"
#include "client/cli/common/terminal.h"
#include "client/cli/remote/admin_run.h"
#include "client/cli/remote/answer_text.h"
#include "client/cli/remote/server_options.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;

struct SessionArguments {
  client::ChannelOptions server;
  std::string session;
  std::string reason;
  std::string vehicle;
  long answer_count = 0;  ///< 0: all
  bool json = false;
};

constexpr std::size_t kShortId = 8;

double Seconds(std::int64_t duration_ns) { return 1e-9 * static_cast<double>(duration_ns); }

void PrintTable(const std::vector<v1::Session>& sessions) {
  const bool has_replicas = std::ranges::any_of(
      sessions, [](const v1::Session& session) { return !session.replica().empty(); });
  std::vector<std::vector<std::string>> rows = {{"session", "vehicle", "map", "state", "scans",
                                                 "refused", "missing", "resumed", "idle", "client",
                                                 "without"}};
  if (has_replicas) rows.front().push_back("replica");
  for (const v1::Session& session : sessions) {
    rows.push_back({session.session_id().substr(0, kShortId), session.vehicle_id(),
                    absl::StrCat(session.map_name(), ":", session.map_version()),
                    absl::StrCat(StateText(session.state()), session.detached() ? " (away)" : ""),
                    absl::StrCat(session.scan_count()), absl::StrCat(session.rejected_scan_count()),
                    absl::StrCat(session.missing_scan_count()),
                    absl::StrCat(session.resume_count()),
                    AgeText(Seconds(session.idle_duration_ns())), session.peer(),
                    SetAsideText(session.health())});
    if (has_replicas) rows.back().push_back(session.replica());
  }
  absl::PrintF("%s", FormatTable(rows));
}

absl::Status List(client::AdminClient& admin, const SessionArguments& arguments) {
  std::vector<v1::ReplicaFault> unanswered;
  absl::StatusOr<std::vector<v1::Session>> sessions = admin.ListSessions(&unanswered);
  if (!sessions.ok()) return sessions.status();
  for (const v1::ReplicaFault& fault : unanswered) {
    absl::FPrintF(stderr, "sessions at %s are missing: %s\n", Visible(fault.address()),
                  Visible(fault.fault()));
  }
  if (!arguments.vehicle.empty()) {
    std::erase_if(*sessions, [&](const v1::Session& session) {
      return session.vehicle_id() != arguments.vehicle;
    });
  }
  if (!arguments.json) {
    PrintTable(*sessions);
    return absl::OkStatus();
  }
  ordered_json list = ordered_json::array();
  for (const v1::Session& session : *sessions) list.push_back(SessionJson(session));
  absl::PrintF("%s\n", list.dump(2));
  return absl::OkStatus();
}

absl::Status Show(client::AdminClient& admin, const SessionArguments& arguments) {
  const absl::StatusOr<v1::Session> session = FindSession(admin, arguments.session);
  if (!session.ok()) return session.status();
  const ordered_json json = SessionJson(*session);
  if (arguments.json) {
    absl::PrintF("%s\n", json.dump(2));
    return absl::OkStatus();
  }
  for (const auto& [key, value] : json.items()) {
    absl::PrintF("%-22s %s\n", key,
                 value.is_string() ? Visible(value.get<std::string>()) : value.dump());
  }
  return absl::OkStatus();
}

absl::Status Watch(client::AdminClient& admin, const SessionArguments& arguments,
                   const StopSignals& signals) {
  const absl::StatusOr<v1::Session> session = FindSession(admin, arguments.session);
  if (!session.ok()) return session.status();
  std::stop_source stop;
  const std::jthread watcher = signals.Watch([&stop](int) { stop.request_stop(); });
  long count = 0;
  std::int64_t missed = 0;
  return admin.WatchSession(
      session->session_id(), stop.get_token(), [&](const v1::WatchSessionResponse& response) {
        if (response.missed_answer_count() > missed) {
          absl::FPrintF(stderr, "%d answers missed\n", response.missed_answer_count() - missed);
          missed = response.missed_answer_count();
        }
        if (arguments.answer_count > 0 && count >= arguments.answer_count) return;
        absl::PrintF("%s\n", arguments.json ? AnswerJson(response.answer()).dump()
                                            : Visible(AnswerLine(response.answer())));
        std::fflush(stdout);
        if (++count == arguments.answer_count) stop.request_stop();
      });
}

absl::Status End(client::AdminClient& admin, const SessionArguments& arguments) {
  const absl::StatusOr<v1::Session> session = FindSession(admin, arguments.session);
  if (!session.ok()) return session.status();
  absl::Status status = admin.EndSession(session->session_id(), arguments.reason);
  if (!status.ok()) return status;
  if (arguments.json) {
    absl::PrintF("%s\n", SessionJson(*session).dump(2));
  } else {
    absl::PrintF("session %s of %s is being ended\n", Visible(session->session_id()),
                 Visible(session->vehicle_id()));
  }
  return absl::OkStatus();
}

void AddSession(CLI::App& command, SessionArguments& arguments) {
  command.add_option("session", arguments.session, "Its id, the beginning of it, or its vehicle")
      ->required()
      ->type_name("ID");
}

}  // namespace

CLI::App* AddSessionCommand(CLI::App& app, int& exit_code) {
  CLI::App* session = app.add_subcommand("session", "See and end a server's sessions");
  session->require_subcommand(1);

  auto list = std::make_shared<SessionArguments>();
  CLI::App* command =
      AddAdminCommand(*session, "list", "List the open sessions", list, exit_code, &List);
  command->add_option("--vehicle", list->vehicle, "Only this vehicle's")->type_name("NAME");
  command->footer("Example:\n  dcloc session list --server localhost:50051 --json");

  auto show = std::make_shared<SessionArguments>();
  command = AddAdminCommand(*session, "show", "Say all about a session", show, exit_code, &Show);
  AddSession(*command, *show);
  command->footer("Example:\n  dcloc session show --server localhost:50051 car-17");

  auto watch = std::make_shared<SessionArguments>();
  command = AddAdminCommand(
      *session, "watch", "Print a session's answers as they are given, until Ctrl-C", watch,
      exit_code, [](const SessionArguments& arguments) {
        const StopSignals signals;  // before gRPC has threads
        return WithAdminClient(arguments.server, [&](client::AdminClient& admin) {
          return Watch(admin, arguments, signals);
        });
      });
  AddSession(*command, *watch);
  command->add_option("--count", watch->answer_count, "End after so many answers")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  command->footer(
      "Looks on, and never slows the session. With --json, an object on each line.\n"
      "Example:\n  dcloc session watch --server localhost:50051 car-17");

  auto end = std::make_shared<SessionArguments>();
  command =
      AddAdminCommand(*session, "end", "End a session; its vehicle is told", end, exit_code, &End);
  AddSession(*command, *end);
  command->add_option("--reason", end->reason, "Told to the vehicle, at most 200 characters")
      ->type_name("TEXT");
  command->footer(
      "Example:\n  dcloc session end --server localhost:50051 car-17 --reason \"radar "
      "misaligned\"");
  return session;
}

}  // namespace dcloc::cli
