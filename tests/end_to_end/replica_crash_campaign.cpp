#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/maps/catalogue/build_queue.h"
#include "tests/core/map/temporary_folder.h"
#include "tests/end_to_end/build_ledger.h"
#include "tests/end_to_end/map_ledger.h"
#include "tests/end_to_end/run_program.h"
#include "tests/end_to_end/server_process.h"
#include "tests/server/fixtures/postgres_cluster.h"

// Kills servers that share a catalogue in PostgreSQL and a folder of map files, each at a random
// moment of uploads, activations, deletions and builds, and holds what is there against what any of
// them had acknowledged.
namespace dcloc {
namespace {

constexpr int kNotInstalled = 77;  // ctest takes it for skipped
/// What a dead server held is free once its lease is over, and then goes with the next sweep.
constexpr std::chrono::seconds kOrphansGoWithin(120);
/// So do builds, which another server then begins anew.
constexpr std::chrono::seconds kBuildsEndWithin(120);

struct Arguments {
  std::string server;
  int kill_count = 3;
  int replica_count = 3;
  unsigned seed = 1;
};

class Campaign {
 public:
  explicit Campaign(const Arguments& arguments)
      : arguments_(arguments),
        random_(arguments.seed),
        database_(server::PostgresCluster::Get().NewDatabase()) {
    std::filesystem::create_directory(SharedFolder());
    for (unsigned i = 0; i < kMaps; ++i) {
      ledgers_.push_back(std::make_unique<MapLedger>(absl::StrCat("map-", i),
                                                     folder_.path().string(), arguments.seed + i,
                                                     MapLedger::Servers::kSeveral));
    }
  }

  absl::Status Run() {
    absl::Status status = StartAll();
    while (status.ok() && kill_count_ < arguments_.kill_count) {
      status = KillAtWork();
      if (status.ok()) status = StartAll();
      if (status.ok()) status = CheckEach();
    }
    if (status.ok()) status = FinishBuilds();
    if (status.ok()) status = WaitUntilNoOrphanIsLeft();
    if (status.ok()) return status;
    return absl::InternalError(absl::StrFormat("after kill %d: %s", kill_count_, status.message()));
  }

  void Report() const {
    const MapLedger::Counts counts = MapLedger::Sum(ledgers_);
    absl::PrintF(
        "%d kills of %d servers: %d changes acknowledged, none lost; %d cut off, of these %d "
        "uploads made anew; no orphan left after %.0f s\n",
        kill_count_, arguments_.replica_count, counts.acknowledged, counts.doubtful,
        counts.finished, orphans_s_);
    absl::PrintF("%d builds acknowledged, each made or, %d of them, given up after %d servers\n",
                 builds_.acknowledged_count(), builds_.given_up_count(),
                 server::BuildQueue::kMaxAttempts);
  }

 private:
  static constexpr unsigned kMaps = 6;

  absl::Status StartAll() {
    servers_.clear();
    for (int i = 0; i < arguments_.replica_count; ++i) {
      servers_.push_back(std::make_unique<ServerProcess>(
          arguments_.server, folder_.path() / absl::StrCat("data-", i), folder_.path() / "log",
          ServerProcessOptions{
              .arguments = {"--catalogue", database_, "--map-folder", SharedFolder().string()}}));
    }
    for (const auto& server : servers_) {
      if (!server->WaitUntilReady()) return absl::InternalError("a server did not start");
    }
    return absl::OkStatus();
  }

  ServerProcess& AnyServer() {
    return *servers_[std::uniform_int_distribution<std::size_t>(0, servers_.size() - 1)(random_)];
  }

  /// One server after the other, while the rest goes on.
  absl::Status KillAtWork() {
    std::vector<absl::Status> results(ledgers_.size());
    absl::Status build_result;
    {
      std::vector<std::jthread> workers;
      for (std::size_t i = 0; i < ledgers_.size(); ++i) {
        const ServerProcess& server = *servers_[i % servers_.size()];
        workers.emplace_back(
            [&, i] { results[i] = ledgers_[i]->Work(client::MapClient(server.Channel())); });
      }
      const ServerProcess& builder = AnyServer();
      workers.emplace_back(
          [&] { build_result = builds_.Work(client::MapClient(builder.Channel())); });
      std::vector<std::size_t> order(servers_.size());
      std::iota(order.begin(), order.end(), std::size_t{0});
      std::ranges::shuffle(order, random_);
      for (const std::size_t i : order) {
        std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(
            std::uniform_real_distribution(0.0, 250.0)(random_)));
        servers_[i]->Kill();
        ++kill_count_;
      }
    }
    for (const absl::Status& result : results) {
      if (!result.ok()) return result;
    }
    return build_result;
  }

  absl::Status CheckEach() {
    for (const auto& ledger : ledgers_) {
      client::MapClient maps(AnyServer().Channel());
      if (absl::Status status = ledger->Check(maps); !status.ok()) return status;
    }
    client::MapClient maps(AnyServer().Channel());
    return builds_.Check(maps);
  }

  absl::Status FinishBuilds() {
    client::MapClient maps(AnyServer().Channel());
    return builds_.Finish(maps, kBuildsEndWithin);
  }

  absl::Status WaitUntilNoOrphanIsLeft() {
    std::set<std::string> expected = builds_.Files();
    for (const auto& ledger : ledgers_) expected.merge(ledger->Files());
    const auto begin = std::chrono::steady_clock::now();
    std::set<std::string> there = FilesThere();
    while (there != expected && std::chrono::steady_clock::now() < begin + kOrphansGoWithin) {
      std::this_thread::sleep_for(std::chrono::seconds(1));
      there = FilesThere();
    }
    orphans_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (there == expected) return absl::OkStatus();
    return absl::InternalError(absl::StrFormat("%d map files are there; %d belong to versions",
                                               there.size(), expected.size()));
  }

  std::set<std::string> FilesThere() const {
    std::set<std::string> there;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(SharedFolder() / "maps")) {
      if (entry.is_regular_file()) there.insert(entry.path().stem().string());
    }
    return there;
  }

  std::filesystem::path SharedFolder() const { return folder_.path() / "shared"; }

  const Arguments arguments_;
  const TemporaryFolder folder_;
  std::mt19937 random_;
  const std::string database_;
  std::vector<std::unique_ptr<MapLedger>> ledgers_;
  BuildLedger builds_{"built"};
  std::vector<std::unique_ptr<ServerProcess>> servers_;
  int kill_count_ = 0;
  double orphans_s_ = 0.0;
};

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(
      "Kills dcloc-servers on one catalogue at random moments and checks that no acknowledged "
      "change of their maps is lost");
  app.add_option("server", arguments.server, "dcloc-server")->required()->check(CLI::ExistingFile);
  app.add_option("--kills", arguments.kill_count, "How often")->check(CLI::PositiveNumber);
  app.add_option("--replicas", arguments.replica_count, "Servers")->check(CLI::Range(1, 20));
  app.add_option("--seed", arguments.seed, "Of the random moments and changes");
  CLI11_PARSE(app, argc, argv);
  if (!server::PostgresCluster::IsInstalled()) {
    std::fprintf(stderr, "skipped: PostgreSQL 15 with PostGIS is not installed\n");
    return kNotInstalled;
  }
  Campaign campaign(arguments);
  return RunCampaign(campaign, arguments.seed);
}

}  // namespace
}  // namespace dcloc

int main(int argc, char** argv) { return dcloc::RunProgram(&dcloc::Main, argc, argv); }
