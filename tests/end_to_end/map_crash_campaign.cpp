#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/end_to_end/map_ledger.h"
#include "tests/end_to_end/run_program.h"
#include "tests/end_to_end/server_process.h"

// Kills the server again and again in the middle of uploads, activations and deletions, and after
// each restart holds its store against what it had acknowledged.
namespace dcloc {
namespace {

struct Arguments {
  std::string server;
  int kill_count = 10;
  unsigned seed = 1;
};

class Campaign {
 public:
  explicit Campaign(const Arguments& arguments) : arguments_(arguments), random_(arguments.seed) {
    for (unsigned i = 0; i < kMaps; ++i) {
      ledgers_.push_back(std::make_unique<MapLedger>(absl::StrCat("map-", i),
                                                     folder_.path().string(), arguments.seed + i));
    }
  }

  absl::Status Run() {
    for (int kill = 0; kill < arguments_.kill_count; ++kill) {
      absl::Status status = KillAtWork();
      // Also in the middle of a repair.
      if (status.ok() && kill % 5 == 0) KillAtStart();
      if (status.ok()) status = CheckAfterRestart();
      if (!status.ok()) {
        return absl::InternalError(
            absl::StrFormat("after kill %d: %s", kill + 1, status.message()));
      }
    }
    return absl::OkStatus();
  }

  void Report() const {
    const MapLedger::Counts counts = MapLedger::Sum(ledgers_);
    absl::PrintF(
        "%d kills: %d changes acknowledged, none lost; %d cut off, of these %d uploads gone on "
        "with\n",
        arguments_.kill_count, counts.acknowledged, counts.doubtful, counts.finished);
  }

 private:
  static constexpr unsigned kMaps = 4;

  std::unique_ptr<ServerProcess> Start() {
    return std::make_unique<ServerProcess>(arguments_.server, Store(), folder_.path() / "log");
  }

  void SleepUpTo(double max_ms) {
    const double ms = std::uniform_real_distribution(0.0, max_ms)(random_);
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(ms));
  }

  absl::Status KillAtWork() {
    const auto server = Start();
    if (!server->WaitUntilReady()) return absl::InternalError("the server did not start");
    std::vector<absl::Status> results(ledgers_.size());
    {
      std::vector<std::jthread> workers;
      for (std::size_t i = 0; i < ledgers_.size(); ++i) {
        workers.emplace_back(
            [&, i] { results[i] = ledgers_[i]->Work(client::MapClient(server->Channel())); });
      }
      SleepUpTo(250.0);
      server->Kill();
    }
    for (const absl::Status& result : results) {
      if (!result.ok()) return result;
    }
    return absl::OkStatus();
  }

  void KillAtStart() {
    const auto server = Start();
    SleepUpTo(40.0);
    server->Kill();
  }

  absl::Status CheckAfterRestart() {
    const auto server = Start();
    if (!server->WaitUntilReady()) return absl::InternalError("the server did not start again");
    client::MapClient maps(server->Channel());
    std::set<std::string> expected;
    for (const auto& ledger : ledgers_) {
      if (absl::Status status = ledger->Check(maps); !status.ok()) return status;
      expected.merge(ledger->Files());
    }
    return CheckFiles(expected);
  }

  absl::Status CheckFiles(const std::set<std::string>& expected) const {
    std::set<std::string> there;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(Store() / "maps")) {
      if (entry.is_regular_file()) there.insert(entry.path().stem().string());
    }
    if (there != expected) {
      return absl::InternalError(absl::StrFormat("%d map files are there; %d belong to versions",
                                                 there.size(), expected.size()));
    }
    const auto incoming = std::filesystem::directory_iterator(Store() / "incoming");
    const auto left = std::distance(begin(incoming), end(incoming));
    if (left == 0) return absl::OkStatus();
    return absl::InternalError(absl::StrFormat("%d unfinished uploads are left", left));
  }

  std::filesystem::path Store() const { return folder_.path() / "store"; }

  const Arguments arguments_;
  const TemporaryFolder folder_;
  std::mt19937 random_;
  std::vector<std::unique_ptr<MapLedger>> ledgers_;
};

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(
      "Kills dcloc-server at random moments and checks that no acknowledged change of its "
      "maps is lost");
  app.add_option("server", arguments.server, "dcloc-server")->required()->check(CLI::ExistingFile);
  app.add_option("--kills", arguments.kill_count, "How often")->check(CLI::PositiveNumber);
  app.add_option("--seed", arguments.seed, "Of the random moments and changes");
  CLI11_PARSE(app, argc, argv);
  Campaign campaign(arguments);
  return RunCampaign(campaign, arguments.seed);
}

}  // namespace
}  // namespace dcloc

int main(int argc, char** argv) { return dcloc::RunProgram(&dcloc::Main, argc, argv); }
