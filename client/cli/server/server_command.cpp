#include "client/cli/server/server_command.h"

#include <chrono>
#include <ctime>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/cli/common/exit_codes.h"
#include "client/cli/common/terminal.h"
#include "client/cli/remote/admin_run.h"
#include "client/cli/remote/answer_text.h"
#include "client/cli/remote/server_options.h"

namespace dcloc::cli {
namespace {

using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPoll(200);

struct ServerArguments {
  client::ChannelOptions server;
  std::string replica;
  bool all = false;
  double wait_s = 0.0;
  bool json = false;
};

ordered_json Json(const v1::GetServerStateResponse& state) {
  return {{"replica", state.replica()},
          {"version", state.server_version()},
          {"start_time", TimeText(state.start_time())},
          {"worker_count", state.worker_count()},
          {"session_count", state.session_count()},
          {"detached_session_count", state.detached_session_count()},
          {"max_session_count", state.max_session_count()},
          {"loaded_map_count", state.loaded_map_count()},
          {"scan_count", state.scan_count()},
          {"rejected_scan_count", state.rejected_scan_count()},
          {"dropped_scan_count", state.dropped_scan_count()},
          {"repeated_scan_count", state.repeated_scan_count()},
          {"resume_count", state.resume_count()},
          {"draining", state.draining()},
          {"stub_matcher", state.stub_matcher()},
          {"unopened_stream_count", state.unopened_stream_count()},
          {"max_unopened_stream_count", state.max_unopened_stream_count()},
          {"awaited_request_count", state.awaited_request_count()},
          {"certificate_expire_time", state.has_certificate_expire_time()
                                          ? ordered_json(TimeText(state.certificate_expire_time()))
                                          : ordered_json()},
          {"certificate_fault", state.certificate_fault()}};
}

/// Until when the certificate holds, and what is wrong with the files that are there now.
std::string CertificateText(const v1::GetServerStateResponse& state) {
  if (!state.has_certificate_expire_time()) return "none, plaintext";
  std::string until = absl::StrCat("until ", TimeText(state.certificate_expire_time()));
  if (state.certificate_fault().empty()) return until;
  return absl::StrCat(
      until, "; the files that are there now are not shown: ", Visible(state.certificate_fault()));
}

ordered_json Json(const v1::Replica& replica) {
  return {{"replica", replica.address()},
          {"state", replica.has_state() ? Json(replica.state()) : ordered_json()},
          {"fault", replica.fault()}};
}

std::vector<std::string> RowOf(const v1::Replica& replica) {
  const std::string name = replica.address().empty() ? "this server" : replica.address();
  if (!replica.has_state()) {
    return {name, "-", "-", "-", "-", "-", absl::StrCat("does not answer: ", replica.fault())};
  }
  const v1::GetServerStateResponse& state = replica.state();
  const auto up_s = static_cast<double>(std::time(nullptr) - state.start_time().seconds());
  return {name,
          state.server_version(),
          AgeText(up_s),
          absl::StrCat(state.session_count(), " of ", state.max_session_count()),
          absl::StrCat(state.detached_session_count()),
          absl::StrCat(state.scan_count()),
          state.draining() ? "draining" : "serving"};
}

absl::Status ShowAll(client::AdminClient& admin, const ServerArguments& arguments) {
  const auto replicas = admin.ListReplicas();
  if (!replicas.ok()) return replicas.status();
  std::vector<std::vector<std::string>> rows = {
      {"replica", "version", "up for", "sessions", "away", "scans", "state"}};
  ordered_json json = ordered_json::array();
  int fault_count = 0;
  for (const v1::Replica& replica : *replicas) {
    fault_count += replica.has_state() ? 0 : 1;
    rows.push_back(RowOf(replica));
    json.push_back(Json(replica));
  }
  absl::PrintF("%s", arguments.json ? absl::StrCat(json.dump(2), "\n") : FormatTable(rows));
  if (fault_count == 0) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrFormat("%d of %d replicas do not answer", fault_count, replicas->size()));
}

absl::Status ShowStatus(client::AdminClient& admin, const ServerArguments& arguments) {
  if (arguments.all) return ShowAll(admin, arguments);
  const auto state = admin.ServerState(arguments.replica);
  if (!state.ok()) return state.status();
  if (arguments.json) {
    absl::PrintF("%s\n", Json(*state).dump(2));
    return absl::OkStatus();
  }
  const auto up_s = static_cast<double>(std::time(nullptr) - state->start_time().seconds());
  absl::PrintF(
      "dcloc-server %s%s, up for %s%s%s\n"
      "sessions  %d of %d at most, %d of them away; resumed %d times\n"
      "scans     %d localized, %d refused, %d dropped, %d repeated\n"
      "waiting   %d streams of %d at most have not opened a session, %d calls sent no request\n"
      "maps      %d in memory\n"
      "threads   %d localize\n"
      "TLS       %s\n",
      Visible(state->server_version()),
      state->replica().empty() ? "" : absl::StrCat(" at ", Visible(state->replica())),
      AgeText(up_s), state->draining() ? ", draining" : "",
      state->stub_matcher() ? ", stub localizer: poses mean nothing" : "", state->session_count(),
      state->max_session_count(), state->detached_session_count(), state->resume_count(),
      state->scan_count(), state->rejected_scan_count(), state->dropped_scan_count(),
      state->repeated_scan_count(), state->unopened_stream_count(),
      state->max_unopened_stream_count(), state->awaited_request_count(), state->loaded_map_count(),
      state->worker_count(), CertificateText(*state));
  return absl::OkStatus();
}

/// Waits for the sessions to go, as long as it was asked to.
absl::StatusOr<v1::GetServerStateResponse> WaitUntilEmpty(client::AdminClient& admin,
                                                          const std::string& replica,
                                                          double wait_s) {
  const Clock::time_point end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                   std::chrono::duration<double>(wait_s));
  while (true) {
    auto state = admin.ServerState(replica);
    if (!state.ok() || state->session_count() == 0 || Clock::now() >= end) return state;
    std::this_thread::sleep_for(kPoll);
  }
}

absl::Status Drain(client::AdminClient& admin, const ServerArguments& arguments) {
  const absl::StatusOr<int> told = admin.Drain(arguments.replica);
  if (!told.ok()) return told.status();
  const auto state = WaitUntilEmpty(admin, arguments.replica, arguments.wait_s);
  if (!state.ok()) return state.status();
  if (arguments.json) {
    ordered_json json = Json(*state);
    json["told_session_count"] = *told;
    absl::PrintF("%s\n", json.dump(2));
  } else {
    absl::PrintF("draining: %d sessions are told to move, %d are open\n", *told,
                 state->session_count());
  }
  if (arguments.wait_s == 0.0 || state->session_count() == 0) return absl::OkStatus();
  return absl::DeadlineExceededError(absl::StrFormat("%d sessions are still open after %g s",
                                                     state->session_count(), arguments.wait_s));
}

/// "ok", or the code and what the server said.
std::string ResultText(const v1::Operation& operation) {
  if (operation.status_code() == 0) return "ok";
  const auto code = static_cast<absl::StatusCode>(operation.status_code());
  return absl::StrCat(absl::StatusCodeToString(code), ": ", operation.status_message());
}

ordered_json Json(const v1::Operation& operation) {
  return {{"number", operation.number()},
          {"time", TimeText(operation.time())},
          {"principal", operation.principal()},
          {"role", operation.role()},
          {"peer", operation.peer()},
          {"method", operation.method()},
          {"request", operation.request()},
          {"status_code", operation.status_code()},
          {"status_message", operation.status_message()}};
}

absl::Status ShowOperations(client::AdminClient& admin, const ServerArguments& arguments) {
  const auto operations = admin.ListOperations();
  if (!operations.ok()) return operations.status();
  if (arguments.json) {
    ordered_json list = ordered_json::array();
    for (const v1::Operation& operation : *operations) list.push_back(Json(operation));
    absl::PrintF("%s\n", list.dump(2));
    return absl::OkStatus();
  }
  std::vector<std::vector<std::string>> rows = {
      {"time", "who", "role", "client", "call", "asked for", "result"}};
  for (const v1::Operation& operation : *operations) {
    rows.push_back({TimeText(operation.time()), operation.principal(), operation.role(),
                    operation.peer(), operation.method().substr(operation.method().rfind('.') + 1),
                    operation.request(), ResultText(operation)});
  }
  absl::PrintF("%s", FormatTable(rows));
  return absl::OkStatus();
}

void AddReplicaOption(CLI::App& command, ServerArguments& arguments) {
  command
      .add_option("--replica", arguments.replica,
                  "Another server, as \"server status --all\" names it, in place of --server")
      ->type_name("HOST:PORT");
}

}  // namespace

void AddServerCommand(CLI::App& app, int& exit_code) {
  CLI::App* server = app.add_subcommand("server", "See how a server does, and empty it");
  server->require_subcommand(1);

  auto status = std::make_shared<ServerArguments>();
  CLI::App* command = AddAdminCommand(*server, "status", "Say what a server is doing", status,
                                      exit_code, &ShowStatus);
  AddReplicaOption(*command, *status);
  command
      ->add_flag("--all", status->all,
                 "Of each server that shares a catalogue with this one; an error if one does "
                 "not answer")
      ->excludes("--replica");
  command->footer(
      "Examples:\n  dcloc server status --server localhost:50051\n"
      "  dcloc server status --all --server localhost:50051");

  auto operations = std::make_shared<ServerArguments>();
  command = AddAdminCommand(*server, "operations", "Say who changed what lately, newest first",
                            operations, exit_code, &ShowOperations);
  command->footer(
      "The server keeps the last 1,000 since its start; its log has a line for each.\n"
      "Example:\n  dcloc server operations --server localhost:50051 --json");

  auto drain = std::make_shared<ServerArguments>();
  command =
      AddAdminCommand(*server, "drain", "Take no more sessions, and tell the vehicles to move",
                      drain, exit_code, &Drain);
  AddReplicaOption(*command, *drain);
  command
      ->add_option("--wait-s", drain->wait_s,
                   "Wait so long until all have gone; an error if they have not")
      ->check(CLI::Range(0.0, 86400.0))
      ->type_name("S")
      ->capture_default_str();
  command->footer(
      "Only a restart makes the server take sessions again.\n"
      "Example:\n  dcloc server drain --server localhost:50051 --wait-s 30");
}

}  // namespace dcloc::cli
