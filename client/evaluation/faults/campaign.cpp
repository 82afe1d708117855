#include "client/evaluation/faults/campaign.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/evaluation/faults/isolation.h"
#include "client/evaluation/faults/judgement.h"
#include "client/evaluation/faults/session.h"
#include "client/evaluation/perturbation.h"

namespace dcloc::faults {
namespace {

constexpr unsigned int kLimit_s = 600;  // of a session, which takes some seconds

Fault Nothing(const char* id, bool is_reversing) {
  Fault fault{.id = id, .family = id, .label = id};
  fault.apply = [](Stream&, const Window&, std::uint64_t) {};
  fault.is_reversing = is_reversing;
  return fault;
}

// What is tried in `world`: first the drives as they are.
std::vector<Fault> FaultsIn(const World& world, const std::vector<Fault>& faults) {
  std::vector<Fault> tried = {Nothing(kUndisturbed, false)};
  for (const Fault& fault : faults) {
    if (fault.min_radars > world.radar_count) continue;
    if (fault.is_reversing && std::ranges::none_of(tried, &Fault::is_reversing)) {
      tried.push_back(Nothing(kUndisturbedReversing, true));
    }
    tried.push_back(fault);
  }
  return tried;
}

/// A world with its map, from the first case on that needs them.
class FaultBench {
 public:
  explicit FaultBench(const World& world) : world_(world) {}

  absl::StatusOr<Record> Try(const Fault& fault) {
    if (absl::Status status = Prepare(); !status.ok()) return status;
    const Drive& drive = fault.is_reversing ? reversed_ : live_;
    if (drive.scans.empty()) return absl::InvalidArgumentError("the drive has no scans");
    const Perturbation perturbation{.translation_m = 0.5, .rotation_deg = 2.0, .seed = world_.seed};
    Stream stream =
        StreamOf(drive, Perturb(drive.scans.front().T_map_vehicle, perturbation, world_.name, 0));
    stream.map = map_;
    const Window window = WindowOf(fault, stream);
    fault.apply(stream, window, world_.seed);
    return RunAside(stream, window);
  }

 private:
  // A session that ends its process is a failure of the localizer, not of the campaign.
  absl::StatusOr<Record> RunAside(const Stream& stream, const Window& window) const {
    const auto text = RunIsolated(
        [&]() -> std::string {
          const auto outcome = RunSession(stream);
          if (!outcome.ok()) return std::string(outcome.status().message());
          return RecordToJson(JudgeFault(*outcome, window)).dump();
        },
        kLimit_s);
    if (absl::IsAborted(text.status())) {
      Record record{.cases = 1, .arrived = stream.scans.size()};
      record.tally.episodes = window.is_open() ? 0 : 1;
      record.failures = {absl::StrCat(world_.name, ": ", text.status().message())};
      return record;
    }
    if (!text.ok()) return text.status();
    const auto json = nlohmann::json::parse(*text, nullptr, /*allow_exceptions=*/false);
    auto record = RecordFromJson(json);
    if (!record) return absl::InvalidArgumentError(*text);
    return *std::move(record);
  }

  absl::Status Prepare() {
    if (map_ != nullptr) return absl::OkStatus();
    auto course = world_.load();
    if (!course.ok()) return course.status();
    auto map = robustness::MapOf(course->map);
    if (!map.ok()) return map.status();
    live_ = std::move(course->live);
    reversed_ = Reversed(live_);
    map_ = *std::move(map);
    return absl::OkStatus();
  }

  const World& world_;
  Drive live_, reversed_;
  std::shared_ptr<const RadarMap> map_;
};

/// The worlds of a campaign, worked off by several threads.
class FaultCampaign {
 public:
  FaultCampaign(const Selection& selection, RecordStore& store,
                const std::function<void(const std::string&, double)>& progress)
      : worlds_(selection.worlds), store_(store), progress_(progress) {
    for (const World& world : worlds_) {
      faults_.push_back(FaultsIn(world, selection.faults));
      total_ += faults_.back().size();
    }
    results_.resize(worlds_.size());
    status_.resize(worlds_.size());
  }

  absl::StatusOr<std::vector<CaseResult>> Run(int jobs) {
    {
      std::vector<std::jthread> workers;
      for (int i = 1; i < jobs; ++i) workers.emplace_back([this] { Work(); });
      Work();
    }
    std::vector<CaseResult> all;
    for (std::size_t i = 0; i < worlds_.size(); ++i) {
      if (!status_[i].ok()) return status_[i];
      for (CaseResult& result : results_[i]) all.push_back(std::move(result));
    }
    return all;
  }

 private:
  void Work() {
    for (std::size_t i = next_++; i < worlds_.size() && !has_failed_; i = next_++) {
      status_[i] = DoWorld(worlds_[i], faults_[i], results_[i]);
      if (!status_[i].ok()) has_failed_ = true;
    }
  }

  absl::Status DoWorld(const World& world, const std::vector<Fault>& faults,
                       std::vector<CaseResult>& results) {
    FaultBench bench(world);
    for (const Fault& fault : faults) {
      const std::string name = absl::StrCat(world.name, ".", fault.id);
      std::optional<Record> record = store_.Load(name);
      if (!record) {
        auto made = bench.Try(fault);
        if (!made.ok()) {
          return absl::Status(made.status().code(),
                              absl::StrCat(name, ": ", made.status().message()));
        }
        if (absl::Status status = store_.Save(name, *made); !status.ok()) return status;
        record = *std::move(made);
      }
      results.push_back({world.name, world.kind, fault.id, *std::move(record)});
      Tell(name);
    }
    return absl::OkStatus();
  }

  void Tell(const std::string& name) {
    const std::scoped_lock lock(mutex_);
    ++done_;
    progress_(name, static_cast<double>(done_) / static_cast<double>(total_));
  }

  const std::vector<World>& worlds_;
  RecordStore& store_;
  const std::function<void(const std::string&, double)>& progress_;
  std::vector<std::vector<Fault>> faults_;        // by world
  std::vector<std::vector<CaseResult>> results_;  // likewise
  std::vector<absl::Status> status_;              // likewise
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> has_failed_ = false;
  std::mutex mutex_;
  std::size_t done_ = 0;
  std::size_t total_ = 0;
};

}  // namespace

absl::StatusOr<std::vector<CaseResult>> RunFaultCampaign(
    const Selection& selection, RecordStore& store, int jobs,
    const std::function<void(const std::string&, double)>& progress) {
  return FaultCampaign(selection, store, progress).Run(jobs);
}

}  // namespace dcloc::faults
