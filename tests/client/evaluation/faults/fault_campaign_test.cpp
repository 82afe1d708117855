#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <mutex>
#include <stdexcept>

#include "client/evaluation/faults/campaign.h"
#include "client/evaluation/faults/isolation.h"
#include "client/evaluation/faults/report.h"
#include "client/evaluation/faults/report_json.h"
#include "client/evaluation/faults/session.h"
#include "client/evaluation/faults/stanford_picture.h"
#include "client/evaluation/faults/velocity_faults.h"
#include "tests/client/evaluation/simulated_drives.h"

namespace dcloc::faults {
namespace {

using ::testing::HasSubstr;

class RecordMemory final : public RecordStore {
 public:
  std::optional<Record> Load(const std::string& name) override {
    const std::scoped_lock lock(mutex_);
    const auto found = records.find(name);
    return found == records.end() ? std::nullopt : std::optional(found->second);
  }
  absl::Status Save(const std::string& name, const Record& record) override {
    const std::scoped_lock lock(mutex_);
    records[name] = record;
    return absl::OkStatus();
  }

  std::map<std::string, Record> records;

 private:
  std::mutex mutex_;
};

const auto kQuiet = [](const std::string&, double) {};

// A street of two hundred metres; at its fifth second the vehicle says that it stands still.
World StreetWorld(const std::string& name, int& load_count) {
  World world{.kind = "street", .name = name};
  world.load = [&load_count]() -> absl::StatusOr<robustness::Course> {
    ++load_count;
    SimulatedDrives drives = SimulateDrives();
    return robustness::Course{std::move(drives.map_drive), std::move(drives.live_drive), {}};
  };
  return world;
}

Fault StandsStill() {
  return {.id = "velocity-zero",
          .family = "velocity",
          .label = "stands still",
          .begin_s = 5.0,
          .duration_s = 1.0,
          .apply = [](Stream& stream, const Window& window, std::uint64_t) {
            ScaleVelocity(stream, window, 0.0, 1.0);
          }};
}

Fault Crashes() {
  Fault fault = StandsStill();
  fault.id = "velocity-crash";
  return fault;
}

TEST(FaultCampaignTest, TriesFaultsBesideTheDriveAsItIs) {
  int load_count = 0;
  RecordMemory store;
  std::vector<double> shares;
  Fault reversing = StandsStill();
  reversing.id = "velocity-reversing";
  reversing.is_reversing = true;
  Fault of_two = StandsStill();
  of_two.id = "velocity-two";
  of_two.min_radars = 2;
  const Selection selection{{StandsStill(), reversing, of_two}, {StreetWorld("s-1", load_count)}};
  const auto results = RunFaultCampaign(
      selection, store, 1, [&](const std::string&, double share) { shares.push_back(share); });
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_EQ(shares, (std::vector<double>{0.25, 0.5, 0.75, 1.0}));
  std::vector<std::string> faults;
  for (const CaseResult& result : *results) faults.push_back(result.fault);
  EXPECT_EQ(faults, (std::vector<std::string>{kUndisturbed, "velocity-zero", kUndisturbedReversing,
                                              "velocity-reversing"}));
  for (const std::size_t i : {0U, 2U}) {
    EXPECT_EQ(results->at(i).record.tally.wrong, 0U) << i;
    EXPECT_GT(results->at(i).record.tally.tracking, 150U) << i;
  }
  EXPECT_EQ(results->at(1).record.tally.episodes, 1U);
  EXPECT_GT(results->at(1).record.meanwhile_scans, 10U);
  EXPECT_EQ(load_count, 1);
}

// On this highway a place 40 m on looks alike.
TEST(FaultCampaignTest, APriorAtAnotherPlaceOfAHighwayIsNotTracked) {
  constexpr int kSeed = 4503;
  Selection selection{AllFaults(false), SimulatedWorlds(kSeed, false)};
  std::erase_if(selection.faults, [](const Fault& fault) { return fault.id != "place-prior-40m"; });
  std::erase_if(selection.worlds, [](const World& world) { return world.name != "highway-2"; });
  RecordMemory store;
  const auto results = RunFaultCampaign(selection, store, 1, kQuiet);
  ASSERT_TRUE(results.ok()) << results.status();
  ASSERT_EQ(results->size(), 2U);
  EXPECT_EQ(results->at(1).record.tally.wrong, 0U);
  EXPECT_GT(results->at(1).record.tally.tracking, 850U);
}

TEST(FaultCampaignTest, GoesOnWhereItWasWithAnyNumberOfThreads) {
  int first_count = 0, second_count = 0;
  RecordMemory store;
  const Selection selection{{StandsStill()},
                            {StreetWorld("s-1", first_count), StreetWorld("s-2", second_count)}};
  const auto results = RunFaultCampaign(selection, store, 2, kQuiet);
  ASSERT_TRUE(results.ok()) << results.status();
  ASSERT_EQ(store.records.size(), 4U);
  store.records.erase("s-2.velocity-zero");
  store.records["s-1.velocity-zero"].arrived = 7;
  const auto again = RunFaultCampaign(selection, store, 1, kQuiet);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(first_count, 1);
  EXPECT_EQ(second_count, 2);
  EXPECT_EQ(again->at(1).record.arrived, 7U);
  EXPECT_EQ(again->at(3).record.errors_m, results->at(3).record.errors_m);
}

TEST(FaultCampaignTest, SaysWhichCaseFailed) {
  World nowhere{.kind = "moon", .name = "moon-1"};
  nowhere.load = []() -> absl::StatusOr<robustness::Course> {
    return absl::NotFoundError("no such drive");
  };
  RecordMemory store;
  const auto results = RunFaultCampaign({{StandsStill()}, {nowhere}}, store, 1, kQuiet);
  EXPECT_EQ(results.status().code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(results.status().message(), "moon-1.undisturbed: no such drive");
}

TEST(IsolationTest, ACrashAnExceptionAndALoopEndTheirProcessAlone) {
  const auto result = RunIsolated([] { return std::string(300'000, 'x'); }, 60);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(result->size(), 300'000U);
  const auto killed = RunIsolated(
      []() -> std::string {
        std::raise(SIGKILL);
        return "";
      },
      60);
  EXPECT_EQ(killed.status(), absl::AbortedError("ended by signal 9"));
  const auto thrown = RunIsolated([]() -> std::string { throw std::runtime_error("no"); }, 60);
  EXPECT_EQ(thrown.status(), absl::AbortedError("ended by signal 6"));
  const auto endless = RunIsolated(
      []() -> std::string {
        for (volatile unsigned int turns = 0;;) turns = turns + 1;
      },
      1);
  EXPECT_EQ(endless.status(), absl::AbortedError("ended by signal 24"));
}

TEST(IsolationTest, AProcessThatWaitsForTheProcessorIsNotEnded) {
  const auto result = RunIsolated(
      [] {
        usleep(1'500'000);
        return std::string("done");
      },
      1);
  ASSERT_TRUE(result.ok()) << result.status();
  EXPECT_EQ(*result, "done");
}

TEST(SessionTest, CountsRefusalsAndOrdersAnswersByTrueTime) {
  const SimulatedDrives drives = SimulateDrives();
  Stream stream = StreamOf(drives.live_drive, {drives.live_drive.scans[0].T_map_vehicle,
                                               Matrix6d(1e-2 * Matrix6d::Identity())});
  stream.scans.resize(40);
  // Some come late, and one too late.
  std::rotate(stream.scans.begin() + 20, stream.scans.begin() + 21, stream.scans.begin() + 30);
  std::swap(stream.scans[10], stream.scans[11]);
  EXPECT_FALSE(RunSession(stream).ok()) << "there is no map";
  stream.map = dcloc::MapOf(drives.map_drive);
  const auto outcome = RunSession(stream);
  ASSERT_TRUE(outcome.ok()) << outcome.status();
  EXPECT_EQ(outcome->arrived, 40U);
  EXPECT_EQ(outcome->drive.refused_count, 1U);
  EXPECT_EQ(outcome->drive.scans.size(), 39U);
  EXPECT_EQ(outcome->protection_level_m.size(), 39U);
  EXPECT_THAT(outcome->drive.first_refusal, HasSubstr("stamp"));
  EXPECT_GT(outcome->longest_call_ms, 0.0);
  EXPECT_EQ(outcome->failure, "");
}

std::vector<CaseResult> MadeResults() {
  const auto record = [](double error_m, std::size_t wrong) {
    Record made{.cases = 1, .arrived = 100};
    made.tally.scans = made.tally.tracking = 100;
    made.tally.wrong = wrong;
    made.errors_m.assign(100, error_m);
    return made;
  };
  Record fault = record(3.0, 40);
  fault.tally.episodes = 1;
  fault.failures = {"town-1: ended by signal 11"};
  return {{"town-1", "town", kUndisturbed, record(0.02, 0)},
          {"town-1", "town", "velocity-zero", fault},
          {"town-2", "town", kUndisturbed, record(0.04, 0)},
          {"tunnel-1", "tunnel", kUndisturbed, record(0.06, 0)},
          {"tunnel-1", "tunnel", "velocity-zero", record(1.0, 0)}};
}

TEST(FaultReportTest, PutsEachFaultBesideTheSameWorldsAsTheyAre) {
  const std::vector<CaseResult> results = MadeResults();
  const std::vector<FaultRows> rows = RowsOf(results, {StandsStill(), Crashes()});
  ASSERT_EQ(rows.size(), 2U);  // the other fault has no results
  EXPECT_EQ(rows[1].all.record.cases, 2U);
  EXPECT_EQ(rows[1].all.undisturbed.cases, 2U);  // town-2 was not tried
  ASSERT_EQ(rows[1].by_kind.size(), 2U);
  EXPECT_EQ(rows[1].by_kind[1].name, "tunnel");
  const robustness::TextTable text = FaultText(rows, true);
  ASSERT_EQ(text.size(), 7U);  // the header, and two faults with two kinds of world each
  EXPECT_EQ(text[4][0], "stands still");
  EXPECT_EQ(text[5][0], "- town");
  EXPECT_EQ(text[5][4], "40");
  EXPECT_EQ(text[5][8], "never / never / never");
  EXPECT_EQ(text[5][9], "3.00 / 3.00");
  EXPECT_EQ(text[5][10], "0.02 / 0.02");
  EXPECT_EQ(text[6][8], "-");
  EXPECT_EQ(FailureText(rows).size(), 2U);
  const auto json = FaultJson(rows, results);
  ASSERT_EQ(json["faults"].size(), 2U);
  EXPECT_EQ(json["faults"][1]["wrong"], 40);
  EXPECT_EQ(json["faults"][1]["worlds"].size(), 2U);
  EXPECT_TRUE(json["faults"][1]["recovery_s"]["max"].is_null());
  EXPECT_EQ(json["faults"][1]["undisturbed_error_m"]["count"], 200);
  const std::string html = FaultHtml(rows, {{"Seed", "1 < 2"}}, "", "Left out: none & nothing");
  EXPECT_THAT(html, HasSubstr("1 &lt; 2"));
  EXPECT_THAT(html, HasSubstr("Left out: none &amp; nothing"));
  EXPECT_THAT(html, HasSubstr("ended by signal 11"));
}

TEST(FaultReportTest, DrawsAStanfordDiagram) {
  StanfordHistogram histogram;
  histogram.Add(0.1, 1.0);
  histogram.Add(2.0, 1.0);
  histogram.Add(0.0, 1e9);
  const auto svg = RenderSvg(StanfordPicture(histogram));
  if (absl::IsNotFound(svg.status())) GTEST_SKIP() << svg.status();
  ASSERT_TRUE(svg.ok()) << svg.status();
  EXPECT_THAT(*svg, HasSubstr("protection level [m]"));
}

}  // namespace
}  // namespace dcloc::faults
