#include "client/evaluation/robustness/campaign.h"

#include <memory>

#include "absl/strings/str_cat.h"

namespace dcloc::robustness {
namespace {

/// The drives of a site and the map made of them, from the first trial on that needs them.
class Workbench {
 public:
  explicit Workbench(const Site& site) : site_(site) {}

  absl::StatusOr<Tally> Do(const Trial& trial, const std::function<void(double)>& progress) {
    if (!course_) {
      auto loaded = site_.load();
      if (!loaded.ok()) return loaded.status();
      auto map = MapOf(loaded->map);
      if (!map.ok()) return map.status();
      course_ = *std::move(loaded);
      map_ = *std::move(map);
    }
    return RunTrial(trial, *course_, map_, progress);
  }

 private:
  const Site& site_;
  std::optional<Course> course_;
  std::shared_ptr<const RadarMap> map_;
};

}  // namespace

absl::StatusOr<std::vector<TrialResult>> RunCampaign(
    const std::vector<Site>& sites, TallyStore& store,
    const std::function<void(const std::string&, double)>& progress) {
  std::size_t total = 0;
  for (const Site& site : sites) total += site.trials.size();
  std::vector<TrialResult> results;
  for (const Site& site : sites) {
    Workbench workbench(site);
    for (const auto& [row, trial] : site.trials) {
      const std::string name = absl::StrCat(site.name, ".", row);
      const auto tell = [&](double share) {
        progress(name, (static_cast<double>(results.size()) + share) / static_cast<double>(total));
      };
      tell(0.0);
      std::optional<Tally> tally = store.Load(name);
      if (!tally) {
        auto made = workbench.Do(trial, tell);
        if (!made.ok()) {
          return absl::Status(made.status().code(),
                              absl::StrCat(name, ": ", made.status().message()));
        }
        if (absl::Status status = store.Save(name, *made); !status.ok()) return status;
        tally = *std::move(made);
      }
      results.push_back({site.name, row, *std::move(tally)});
    }
  }
  return results;
}

}  // namespace dcloc::robustness
