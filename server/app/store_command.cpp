#include "server/app/store_command.h"

#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "nlohmann/json.hpp"
#include "server/app/identity_mark.h"
#include "server/app/storage.h"
#include "server/app/store_backup.h"
#include "server/app/store_repair.h"
#include "server/base/files.h"
#include "server/base/sqlite_copy.h"
#include "server/config/command_line.h"
#include "server/maps/catalogue/sqlite_catalogue.h"
#include "server/maps/store/map_folder.h"

namespace dcloc::server {
namespace {

using nlohmann::ordered_json;

struct StoreArguments {
  std::string data;
  std::string backup;
  bool adopt = false;
  bool json = false;
};

/// Shows how far the work is where somebody watches, and stops it on SIGINT and SIGTERM, which no
/// other thread takes meanwhile.
class Watcher {
 public:
  explicit Watcher(const char* doing) : doing_(doing), shows_(isatty(STDERR_FILENO) != 0) {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  }
  ~Watcher() {
    if (shows_) std::cerr << "\r\033[K";
  }

  bool operator()(const StoreProgress& progress) {
    const std::int64_t percent =
        progress.size_bytes == 0 ? 100 : 100 * progress.done_bytes / progress.size_bytes;
    if (shows_ && percent != percent_) {
      std::cerr << absl::StrFormat("\r\033[K%s %d %% of %d MB", doing_, percent,
                                   progress.size_bytes / 1'000'000)
                << std::flush;
    }
    percent_ = percent;
    const std::timespec at_once{};
    return sigtimedwait(&signals_, nullptr, &at_once) < 0;
  }

 private:
  const char* doing_;
  const bool shows_;
  sigset_t signals_{};
  std::int64_t percent_ = -1;
};

/// Gives files that root has made in somebody's folder to that somebody, who could not read them.
void GiveToOwner(const std::filesystem::path& folder) {
  struct stat owner {};
  if (geteuid() != 0 || stat(folder.c_str(), &owner) != 0) return;
  std::error_code error;
  std::filesystem::recursive_directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::end(entry); entry.increment(error)) {
    if (lchown(entry->path().c_str(), owner.st_uid, owner.st_gid) != 0) {
      std::cerr << "dcloc-server: " << entry->path().string() << " stays root's\n";
    }
  }
}

ordered_json ToJson(const StoreAudit& audit) {
  return {{"whole", audit.ok()},
          {"file_count", audit.file_count},
          {"size_bytes", audit.size_bytes},
          {"missing_files", audit.missing_files},
          {"damaged_files", audit.damaged_files},
          {"unaccounted_files", audit.unaccounted_files},
          {"quarantined_count", audit.quarantined_count}};
}

std::string ToText(const StoreAudit& audit) {
  std::string text =
      absl::StrFormat("%d map files, %d bytes\n", audit.file_count, audit.size_bytes);
  const auto list = [&text](const std::vector<std::string>& files, const char* what) {
    for (const std::string& sha256 : files) absl::StrAppend(&text, what, "  ", sha256, "\n");
  };
  list(audit.missing_files, "missing      ");
  list(audit.damaged_files, "damaged      ");
  list(audit.unaccounted_files, "unaccounted  ");
  if (audit.quarantined_count > 0) {
    absl::StrAppend(&text, audit.quarantined_count, " files are in quarantine\n");
  }
  return text;
}

/// Of a store that is not whole.
absl::Status WhatMends(const StoreAudit& audit) {
  if (audit.ok()) return absl::OkStatus();
  return absl::DataLossError(
      "the store is not whole; upload missing and damaged files again (dcloc map upload), or "
      "restore a backup; unaccounted files: store repair");
}

ordered_json ToJson(const BackupReport& report) {
  return {{"file_count", report.file_count},
          {"copied_count", report.copied_count},
          {"size_bytes", report.size_bytes},
          {"damaged_files", report.damaged_files}};
}

void Print(const StoreArguments& arguments, const ordered_json& json, const std::string& text) {
  std::cout << (arguments.json ? absl::StrCat(json.dump(2), "\n") : text);
}

absl::Status Check(const StoreArguments& arguments) {
  const StorePaths paths = PathsOf(arguments.data);
  absl::Status status = CheckDatabase(paths.catalogue);
  for (const auto& database : {paths.identities, paths.jobs, paths.passes}) {
    if (status.ok() && IsThere(database)) status = CheckDatabase(database);
  }
  const bool has_identities = FileSize(paths.identities).value_or(0) > 0;
  if (status.ok() && !has_identities) status = CheckNoIdentityIsLost(arguments.data);
  if (!status.ok()) return WithPath(status);
  const auto catalogue = SqliteCatalogue::OpenToRead(paths.catalogue);
  if (!catalogue.ok()) return catalogue.status();
  MapFolder files(paths.maps, paths.quarantine);
  Watcher watcher("checking");
  const absl::StatusOr<StoreAudit> audit = AuditStore(**catalogue, files, std::ref(watcher));
  if (!audit.ok()) return audit.status();
  Print(arguments, ToJson(*audit), ToText(*audit));
  return WhatMends(*audit);
}

absl::Status Repair(const StoreArguments& arguments) {
  Watcher watcher("checking");
  const absl::StatusOr<RepairReport> report =
      RepairStore(arguments.data, {.adopt = arguments.adopt}, std::ref(watcher));
  GiveToOwner(arguments.data);
  if (!report.ok()) return report.status();
  ordered_json json = ToJson(report->audit);
  json["catalogue_replaced"] = report->catalogue_replaced;
  json["set_aside"] = report->set_aside;
  json["adopted_count"] = report->adopted_count;
  json["newly_quarantined_count"] = report->quarantined_count;
  std::string others;
  for (const std::string& name : report->set_aside) {
    absl::StrAppend(&others, name, " was no database; it is kept aside\n");
  }
  Print(arguments, json,
        absl::StrFormat(
            "%s%s%d map files became maps, %d went to quarantine\n%s",
            report->catalogue_replaced ? "the catalogue is new; what was there is kept beside it\n"
                                       : "",
            others, report->adopted_count, report->quarantined_count, ToText(report->audit)));
  return WhatMends(report->audit);
}

absl::Status BackUp(const StoreArguments& arguments) {
  Watcher watcher("copying");
  const absl::StatusOr<BackupReport> report =
      BackUpStore(arguments.data, arguments.backup, std::ref(watcher));
  if (!report.ok()) return report.status();
  Print(arguments, ToJson(*report),
        absl::StrFormat("%d map files, %d bytes; %d copied now\n", report->file_count,
                        report->size_bytes, report->copied_count));
  if (report->damaged_files.empty()) return absl::OkStatus();
  return absl::DataLossError(absl::StrFormat(
      "%d map files are missing or damaged in the store and are not in the backup (first: %s)",
      report->damaged_files.size(), report->damaged_files.front()));
}

absl::Status Restore(const StoreArguments& arguments) {
  Watcher watcher("copying");
  const absl::StatusOr<BackupReport> report =
      RestoreStore(arguments.backup, arguments.data, std::ref(watcher));
  GiveToOwner(arguments.data);
  if (!report.ok()) return report.status();
  Print(arguments, ToJson(*report),
        absl::StrFormat("%d map files, %d bytes; %d came from the backup\n", report->file_count,
                        report->size_bytes, report->copied_count));
  return absl::OkStatus();
}

CLI::App* AddStoreSubcommand(CLI::App& store, const char* name, const char* description,
                             absl::Status (*command)(const StoreArguments&),
                             StoreArguments& arguments, absl::Status& result) {
  CLI::App* app = store.add_subcommand(name, description);
  app->add_option("--data", arguments.data, "Folder of the server's store")
      ->required()
      ->type_name("DIR");
  app->add_flag("--json", arguments.json, "Print as JSON");
  app->callback([command, &arguments, &result] { result = command(arguments); });
  return app;
}

void AddStoreSubcommands(CLI::App& store, StoreArguments& arguments, absl::Status& result) {
  AddStoreSubcommand(store, "check", "Read everything against its hash; changes nothing", &Check,
                     arguments, result)
      ->footer(
          "Also beside a running server, and on a backup. Exit code 1 when something is wrong.\n"
          "Example:\n  dcloc-server store check --data /var/lib/dcloc --json");
  CLI::App* app =
      AddStoreSubcommand(store, "repair", "Make a stopped store one that a server starts with",
                         &Repair, arguments, result);
  app->add_flag("--adopt", arguments.adopt,
                "Map files without a version become maps named recovered-HASH");
  app->footer(
      "Nothing is lost: what is no catalogue is kept beside the new one, and map files without a\n"
      "version go to DIR/quarantine (see --quarantine-days).\n"
      "Example:\n  dcloc-server store repair --data /var/lib/dcloc --adopt");
  app = AddStoreSubcommand(store, "backup", "Copy a store, also one that a server works on",
                           &BackUp, arguments, result);
  app->add_option("--to", arguments.backup, "Folder of the backup; one that is there is renewed")
      ->required()
      ->type_name("DIR");
  app->footer("Example:\n  dcloc-server store backup --data /var/lib/dcloc --to /backup/dcloc");
  app = AddStoreSubcommand(store, "restore", "Put a backup's maps in place of a stopped store's",
                           &Restore, arguments, result);
  app->add_option("--from", arguments.backup, "Folder of the backup")->required()->type_name("DIR");
  app->footer(
      "All of the backup is checked first. Identities that are there stay; map files that are not\n"
      "in the backup go to DIR/quarantine.\n"
      "Example:\n  dcloc-server store restore --data /var/lib/dcloc --from /backup/dcloc");
}

}  // namespace

bool IsStoreCommand(int argc, const char* const* argv) {
  return argc > 1 && std::strcmp(argv[1], "store") == 0;
}

int RunStoreCommand(int argc, const char* const* argv) {
  CLI::App app("dcloc-server store: check, repair, back up and restore", "dcloc-server");
  CLI::App* store = app.add_subcommand("store", "Check, repair, back up and restore a store");
  store->require_subcommand(1);
  StoreArguments arguments;
  absl::Status result;
  AddStoreSubcommands(*store, arguments, result);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? EXIT_SUCCESS : kUsageError;
  }
  if (result.ok()) return EXIT_SUCCESS;
  std::cerr << "dcloc-server: " << WithPath(result).message() << "\n";
  return EXIT_FAILURE;
}

}  // namespace dcloc::server
