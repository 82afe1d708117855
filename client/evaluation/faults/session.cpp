#include "client/evaluation/faults/session.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <numeric>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/evaluation/faults/protection_level.h"

namespace dcloc::faults {
namespace {

using CallClock = std::chrono::steady_clock;

bool IsFinite(const Localization& answer) {
  return answer.T_map_vehicle.translation_m.allFinite() &&
         answer.T_map_vehicle.rotation.coeffs().allFinite() && answer.covariance.allFinite();
}

/// A localizer that is given a stream.
class FaultSession {
 public:
  FaultSession(Localizer localizer, std::string name) : localizer_(std::move(localizer)) {
    outcome_.drive.drive = std::move(name);
  }

  void Give(const StreamScan& entry) {
    ++outcome_.arrived;
    const CallClock::time_point begin = CallClock::now();
    const auto answer = localizer_.Localize(entry.scan);
    const std::chrono::duration<double, std::milli> took = CallClock::now() - begin;
    outcome_.longest_call_ms = std::max(outcome_.longest_call_ms, took.count());
    if (!answer.ok()) {
      if (outcome_.drive.refused_count++ == 0) {
        outcome_.drive.first_refusal = std::string(answer.status().message());
      }
      return;
    }
    if (IsFinite(*answer)) {
      Keep(*answer, entry);
    } else {
      ++infinite_count_;
    }
  }

  void Fail(const char* what) { outcome_.failure = absl::StrCat("exception: ", what); }

  SessionOutcome Take() {
    SortByTime();
    if (infinite_count_ > 0 && outcome_.failure.empty()) {
      outcome_.failure = absl::StrCat(infinite_count_, " answers are not finite");
    }
    return std::move(outcome_);
  }

 private:
  void Keep(const Localization& answer, const StreamScan& entry) {
    ScanOutcome& scan = outcome_.drive.scans.emplace_back();
    scan.radar_id = entry.scan.radar_id;
    scan.answer = answer;
    scan.answer.stamp = entry.measured;
    scan.T_map_vehicle_true = entry.T_map_vehicle;
    scan.error =
        ComparePoses(answer.T_map_vehicle, answer.covariance, answer.observed, entry.T_map_vehicle);
    outcome_.protection_level_m.push_back(answer.protection_level_m);
  }

  void SortByTime() {
    std::vector<ScanOutcome>& scans = outcome_.drive.scans;
    std::vector<std::size_t> order(scans.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return scans[i].answer.stamp; });
    std::vector<ScanOutcome> sorted;
    std::vector<std::optional<double>> levels_m;
    sorted.reserve(order.size());
    levels_m.reserve(order.size());
    for (const std::size_t i : order) {
      sorted.push_back(std::move(scans[i]));
      levels_m.push_back(outcome_.protection_level_m[i]);
    }
    scans = std::move(sorted);
    outcome_.protection_level_m = std::move(levels_m);
  }

  Localizer localizer_;
  SessionOutcome outcome_;
  std::size_t infinite_count_ = 0;
};

}  // namespace

absl::StatusOr<SessionOutcome> RunSession(const Stream& stream,
                                          const std::function<void(double)>& progress) {
  auto localizer = Localizer::Create(stream.map, stream.rig, stream.prior);
  if (!localizer.ok()) return localizer.status();
  FaultSession session(*std::move(localizer), stream.name);
  // The localizer promises not to throw: that it does is what is looked for here.
  try {
    for (std::size_t i = 0; i < stream.scans.size(); ++i) {
      session.Give(stream.scans[i]);
      progress(static_cast<double>(i + 1) / static_cast<double>(stream.scans.size()));
    }
  } catch (const std::exception& exception) {
    session.Fail(exception.what());
  }
  return session.Take();
}

}  // namespace dcloc::faults
