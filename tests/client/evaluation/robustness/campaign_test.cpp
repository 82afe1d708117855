#include "client/evaluation/robustness/campaign.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "client/evaluation/robustness/goals.h"
#include "client/evaluation/robustness/report.h"
#include "client/evaluation/robustness/sites.h"
#include "tests/client/evaluation/simulated_drives.h"

namespace dcloc::robustness {
namespace {

using ::testing::HasSubstr;

class MemoryStore final : public TallyStore {
 public:
  std::optional<Tally> Load(const std::string& name) override {
    const auto found = tallies.find(name);
    return found == tallies.end() ? std::nullopt : std::optional(found->second);
  }
  absl::Status Save(const std::string& name, const Tally& tally) override {
    tallies[name] = tally;
    return absl::OkStatus();
  }

  std::map<std::string, Tally> tallies;
};

const auto kSilent = [](const std::string&, double) {};

// A street of two hundred metres, with a start every forty of them and a drive with a gap.
Site Street(int& load_count) {
  Site site{.name = "street"};
  site.load = [&load_count]() -> absl::StatusOr<Course> {
    ++load_count;
    SimulatedDrives drives = SimulateDrives();
    return Course{std::move(drives.map_drive), std::move(drives.live_drive), {}};
  };
  const StartTrial start{.prior = Prior::kPose,
                         .perturbation = {.translation_m = 3.0, .rotation_deg = 5.0},
                         .spacing_m = 40.0};
  site.trials = {{"gap", TrackTrial{.plan = DisturbancePlan{.kinds = {DisturbanceKind::kGap}}}},
                 {"start-3m", start}};
  return site;
}

TEST(CampaignTest, JudgesDrivesAndStarts) {
  int load_count = 0;
  MemoryStore store;
  std::vector<double> shares;
  const auto results =
      RunCampaign({Street(load_count)}, store,
                  [&](const std::string&, double share) { shares.push_back(share); });
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_EQ(load_count, 1);
  EXPECT_TRUE(std::ranges::is_sorted(shares));
  EXPECT_LE(shares.back(), 1.0);
  ASSERT_EQ(results->size(), 2U);
  const Tally& gap = results->at(0).tally;
  EXPECT_EQ(gap.episodes, 1U);
  EXPECT_GT(gap.scans, 180U);
  EXPECT_EQ(gap.right + gap.flagged + gap.wrong, gap.scans);
  const Tally& starts = results->at(1).tally;
  EXPECT_EQ(starts.starts, 5U);
  EXPECT_GE(starts.right_claim_s.size(), 4U);
  EXPECT_EQ(starts.wrong_claims, 0U);
}

TEST(CampaignTest, GoesOnWhereItWas) {
  int load_count = 0;
  MemoryStore store;
  store.tallies["street.gap"].scans = 7;
  const auto results = RunCampaign({Street(load_count)}, store, kSilent);
  ASSERT_TRUE(results.ok()) << results.status();
  EXPECT_EQ(results->at(0).tally.scans, 7U);
  EXPECT_EQ(load_count, 1);
  const auto again = RunCampaign({Street(load_count)}, store, kSilent);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(load_count, 1);  // nothing was left to do
  EXPECT_EQ(again->at(1).tally.scans, results->at(1).tally.scans);
}

TEST(CampaignTest, SaysWhichTrialFailed) {
  Site site{.name = "nowhere"};
  site.load = []() -> absl::StatusOr<Course> { return absl::NotFoundError("no such drive"); };
  site.trials = {{"gap", TrackTrial{}}};
  MemoryStore store;
  const auto results = RunCampaign({site}, store, kSilent);
  EXPECT_EQ(results.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(results.status().message()), HasSubstr("nowhere.gap: no such drive"));
}

TEST(SitesTest, AskKnownQuestionsUnderNamesOfTheirOwn) {
  for (const bool quick : {false, true}) {
    std::set<std::string> names, rows;
    for (const Site& site : SimulatedSites(1, quick)) {
      EXPECT_TRUE(names.insert(site.name).second) << site.name;
      for (const auto& trial : site.trials) {
        const auto& row = trial.first;
        EXPECT_TRUE(std::ranges::any_of(kRows, [&](const Row& known) { return known.id == row; }))
            << row;
        rows.insert(row);
      }
    }
    const auto recorded = std::ranges::count_if(kRows, &Row::is_recorded);
    EXPECT_EQ(rows.size(), kRows.size() - static_cast<std::size_t>(recorded));
  }
  EXPECT_NE(SimulatedSites(1, true)[0].name, SimulatedSites(2, true)[0].name);
}

// What is asked for is there: the live drive passes its tunnel once, and is disturbed by nothing
// else.
TEST(SitesTest, ATunnelIsAnEpisode) {
  for (const Site& site : SimulatedSites(1, true)) {
    if (site.trials.front().first != "tunnel") continue;
    const auto course = site.load();
    ASSERT_TRUE(course.ok()) << course.status();
    ASSERT_EQ(course->episodes.size(), 1U);
    const double seconds =
        std::chrono::duration<double>(course->episodes[0].end - course->episodes[0].begin).count();
    EXPECT_NEAR(seconds, 100.0 / (60.0 / 3.6), 1.5);
    return;
  }
  FAIL() << "no site has a tunnel";
}

std::vector<TrialResult> Results() {
  Tally drive{.scans = 100'000,
              .right = 99'950,
              .flagged = 50,
              .nees_per_dof_sum = 1e5,
              .nees_count = 100'000,
              .inside_95 = 95'000,
              .episodes = 3,
              .recovery_s = {0.1, 0.2, 0.9}};
  Tally start{.scans = 900, .right = 900, .starts = 100};
  start.right_claim_s.assign(99, 0.7);
  return {{"a", "gap", drive}, {"b", "start-none", start}};
}

bool Meets(const std::vector<TrialResult>& results, const std::string& goal) {
  for (const GoalResult& result : JudgeGoals(results)) {
    if (result.goal.find(goal) != std::string::npos) return result.is_met;
  }
  ADD_FAILURE() << "no goal says " << goal;
  return false;
}

TEST(GoalsTest, AreMetAndMissedAtTheirBounds) {
  const auto met = Results();
  for (const char* goal : {"99.9 % right", "no misleading", "within 1 s", "ANEES", "within 2 s"}) {
    EXPECT_TRUE(Meets(met, goal)) << goal;
  }
  const auto after = [&](const auto& change) {
    auto results = Results();
    change(results[0].tally, results[1].tally);
    return results;
  };
  EXPECT_FALSE(Meets(after([](Tally& t, Tally&) { t.right = 99'899; }), "99.9 % right"));
  EXPECT_FALSE(Meets(after([](Tally& t, Tally&) { t.wrong = 1; }), "99.9 % right"));
  EXPECT_FALSE(Meets(after([](Tally&, Tally& t) { t.misleading = 1; }), "no misleading"));
  EXPECT_FALSE(Meets(after([](Tally& t, Tally&) { t.scans = 99'000; }), "no misleading"));
  EXPECT_FALSE(Meets(after([](Tally& t, Tally&) { t.recovery_s = {0.1, 0.2}; }), "within 1 s"));
  EXPECT_FALSE(Meets(after([](Tally& t, Tally&) { t.recovery_s[0] = 1.1; }), "within 1 s"));
  EXPECT_FALSE(Meets(after([](Tally& t, Tally&) { t.inside_95 = 99'000; }), "ANEES"));
  EXPECT_FALSE(Meets(after([](Tally& t, Tally&) { t.nees_per_dof_sum = 5e4; }), "ANEES"));
  const auto meanwhile = after([](Tally& t, Tally&) {
    t.disturbed_nees_per_dof_sum = 40.0;
    t.disturbed_nees_count = 10;
  });
  EXPECT_FALSE(Meets(meanwhile, "meanwhile"));
  EXPECT_FALSE(Meets(after([](Tally&, Tally& t) { t.wrong_claims = 1; }), "within 2 s"));
  EXPECT_FALSE(Meets(after([](Tally&, Tally& t) { t.right_claim_s[0] = 2.1; }), "within 2 s"));
}

TEST(ReportTest, SaysTheSameInTextJsonAndHtml) {
  const auto results = Results();
  const TextTable drives = TrackText(results, true);
  ASSERT_EQ(drives.size(), 3U);  // the header, the row, its site
  EXPECT_EQ(drives[1][0], "2 s without data");
  EXPECT_EQ(drives[1][2], "99.95");
  EXPECT_EQ(drives[1][7], "0.20 / 0.90 / 0.90");
  const TextTable starts = StartText(results, false);
  ASSERT_EQ(starts.size(), 2U);
  EXPECT_EQ(starts[1][2], "99.0");
  EXPECT_EQ(starts[1][5], "1");
  EXPECT_EQ(starts[1][6], "0.70 / 0.70 / never");
  const auto json = CampaignJson(results);
  EXPECT_EQ(json["rows"].size(), 2U);
  EXPECT_EQ(json["rows"][0]["id"], "gap");
  EXPECT_EQ(json["rows"][0]["recovery_s"]["p50"], 0.2);
  EXPECT_TRUE(json["rows"][1]["right_claim_s"]["max"].is_null());
  EXPECT_EQ(json["goals"].size(), JudgeGoals(results).size());
  const std::string html = CampaignHtml(results, {{"Seed", "1 < 2"}});
  EXPECT_THAT(html, HasSubstr("2 s without data"));
  EXPECT_THAT(html, HasSubstr("1 &lt; 2"));
  EXPECT_THAT(html, HasSubstr("met"));
}

}  // namespace
}  // namespace dcloc::robustness
