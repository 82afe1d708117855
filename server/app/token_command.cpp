#include "server/app/token_command.h"

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/time/time.h"
#include "nlohmann/json.hpp"
#include "server/app/identity_mark.h"
#include "server/app/storage.h"
#include "server/config/command_line.h"

namespace dcloc::server {
namespace {

constexpr int kPageSize = 1000;  ///< of identities that are read at once

struct Arguments {
  ServerConfig config;  ///< of which only the identities' place counts
  Principal principal;
  std::string role;
  int expire_days = 90;
  bool certificate = false;
  bool json = false;
  std::int64_t id = 0;
};

std::string TimeText(const std::optional<SystemTime>& time) {
  if (!time) return "";
  return absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", absl::FromChrono(*time), absl::UTCTimeZone());
}

absl::StatusOr<std::unique_ptr<IdentityStore>> OpenIdentitiesOf(const Arguments& arguments) {
  if (!arguments.config.catalogue.empty()) {
    absl::Status status = Validate(DatabaseOptionsOf(arguments.config));
    if (!status.ok()) return status;
  }
  return OpenIdentities(arguments.config);
}

/// The embedded catalogue notes that there are identities, which lie in another file.
void NoteIdentities(const ServerConfig& config) {
  if (!config.catalogue.empty()) return;
  const absl::Status status = SetIdentityMark(config.data);
  if (status.ok()) return;
  std::cerr << "dcloc-server: the next start of the server notes that there are identities: "
            << status.message() << "\n";
}

absl::Status Create(const Arguments& arguments) {
  Principal principal = arguments.principal;
  principal.role = *RoleFromName(arguments.role);
  std::optional<SystemTime> expire_time;
  if (arguments.expire_days > 0) {
    expire_time = std::chrono::system_clock::now() + std::chrono::days(arguments.expire_days);
  }
  const auto store = OpenIdentitiesOf(arguments);
  if (!store.ok()) return store.status();
  const Proof proof = arguments.certificate ? Proof::kCertificate : Proof::kToken;
  const absl::StatusOr<std::string> token = (*store)->Create(proof, principal, expire_time);
  if (!token.ok()) return token.status();
  NoteIdentities(arguments.config);
  // The token alone on standard output, so that it can go straight into a file.
  if (proof == Proof::kToken) std::cout << *token << "\n";
  std::cerr << principal.name << " is known as " << arguments.role
            << (expire_time ? absl::StrCat(" until ", TimeText(expire_time)) : " for good") << "\n";
  return absl::OkStatus();
}

nlohmann::ordered_json Json(const IdentityRecord& record) {
  return {{"id", record.id},
          {"name", record.principal.name},
          {"tenant", record.principal.tenant},
          {"role", std::string(NameOf(record.principal.role))},
          {"proof", record.proof == Proof::kToken ? "token" : "certificate"},
          {"create_time", TimeText(record.create_time)},
          {"expire_time", TimeText(record.expire_time)},
          {"revoke_time", TimeText(record.revoke_time)}};
}

std::string Line(const IdentityRecord& record) {
  return absl::StrCat(
      record.id, "  ", record.principal.name, "  ", NameOf(record.principal.role), "  ",
      record.principal.tenant.empty() ? "(default tenant)" : record.principal.tenant, "  ",
      record.proof == Proof::kToken ? "token" : "certificate",
      record.expire_time ? absl::StrCat("  expires ", TimeText(record.expire_time)) : "",
      record.revoke_time ? absl::StrCat("  revoked ", TimeText(record.revoke_time)) : "", "\n");
}

absl::Status List(const Arguments& arguments) {
  const auto store = OpenIdentitiesOf(arguments);
  if (!store.ok()) return store.status();
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  std::int64_t last = 0;
  for (bool is_more = true; is_more;) {
    const absl::StatusOr<std::vector<IdentityRecord>> page = (*store)->List(last, kPageSize);
    if (!page.ok()) return page.status();
    for (const IdentityRecord& record : *page) {
      arguments.json ? list.push_back(Json(record)) : void(std::cout << Line(record));
      last = record.id;
    }
    is_more = page->size() == kPageSize;
  }
  if (arguments.json) std::cout << list.dump(2) << "\n";
  return absl::OkStatus();
}

absl::Status Revoke(const Arguments& arguments) {
  const auto store = OpenIdentitiesOf(arguments);
  return store.ok() ? (*store)->Revoke(arguments.id) : store.status();
}

CLI::App* AddCommand(CLI::App& token, const char* name, const char* description,
                     absl::Status (*command)(const Arguments&), Arguments& arguments,
                     absl::Status& result) {
  CLI::App* app = token.add_subcommand(name, description);
  CLI::Option_group* place = app->add_option_group("Place");
  place->add_option("--data", arguments.config.data, "Folder of the server's store")
      ->type_name("DIR");
  place
      ->add_option("--catalogue", arguments.config.catalogue,
                   "Database that servers share, postgresql://USER@HOST/DATABASE")
      ->type_name("URI");
  place->require_option(1);
  app->callback([command, &arguments, &result] { result = command(arguments); });
  return app;
}

void AddCreate(CLI::App& token, Arguments& arguments, absl::Status& result) {
  CLI::App* app = AddCommand(token, "create", "Make an identity; prints its token, this once",
                             &Create, arguments, result);
  app->add_option("--name", arguments.principal.name, "Whose it is; a vehicle's id for a vehicle")
      ->required()
      ->type_name("NAME");
  app->add_option("--role", arguments.role, "vehicle, viewer, operator or admin")
      ->required()
      ->check(CLI::IsMember({"vehicle", "viewer", "operator", "admin"}))
      ->type_name("ROLE");
  app->add_option("--tenant", arguments.principal.tenant,
                  "Whose maps and sessions it sees; the default tenant's without it")
      ->type_name("TENANT");
  app->add_option("--expire-days", arguments.expire_days, "Valid for so long; 0 for good")
      ->check(CLI::Range(0, 3650))
      ->capture_default_str()
      ->type_name("N");
  app->add_flag("--certificate", arguments.certificate,
                "Proven by a client certificate whose common name is NAME, not by a token");
  app->footer(
      "Example:\n  dcloc-server token create --data ./store --name car-1 --role vehicle "
      "> car-1.token");
}

}  // namespace

bool IsTokenCommand(int argc, const char* const* argv) {
  return argc > 1 && std::strcmp(argv[1], "token") == 0;
}

int RunTokenCommand(int argc, const char* const* argv) {
  CLI::App app("dcloc-server token: who may use a server", "dcloc-server");
  CLI::App* token = app.add_subcommand("token", "Make, list and revoke identities");
  token->require_subcommand(1);
  token->footer("What is changed here holds for the next call to a server that runs on the store.");
  Arguments arguments;
  absl::Status result;
  AddCreate(*token, arguments, result);
  AddCommand(*token, "list", "Show all identities", &List, arguments, result)
      ->add_flag("--json", arguments.json, "Print as JSON");
  AddCommand(*token, "revoke", "End an identity", &Revoke, arguments, result)
      ->add_option("--id", arguments.id, "As `list` shows it")
      ->required()
      ->type_name("N");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? EXIT_SUCCESS : kUsageError;
  }
  if (result.ok()) return EXIT_SUCCESS;
  std::cerr << "dcloc-server: " << result.message() << "\n";
  return EXIT_FAILURE;
}

}  // namespace dcloc::server
