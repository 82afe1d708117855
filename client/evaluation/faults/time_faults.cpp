#include "client/evaluation/faults/time_faults.h"

#include <algorithm>
#include <map>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::faults {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

// A radar's period is not exact; a scan that comes a little early still counts.
constexpr double kRateTolerance = 0.02;

Fault MakeTimeFault(const std::string& id, std::string label, std::optional<double> duration_s,
                    Fault::Apply apply) {
  return {.id = absl::StrCat("time-", id),
          .family = "time",
          .label = std::move(label),
          .duration_s = duration_s,
          .apply = std::move(apply)};
}

Fault::Apply Shifting(nanoseconds shift) {
  return [=](Stream& stream, const Window& window, std::uint64_t) {
    // A clock that is set at a moment stays so.
    const bool is_moment = window.begin == window.end;
    ShiftStamps(stream, is_moment ? Window{window.begin} : window, shift);
  };
}

void AddClocks(std::vector<Fault>& faults) {
  faults.push_back(MakeTimeFault("ahead-10min", "clock 10 min ahead for 0.4 s", 0.4,
                                 Shifting(std::chrono::minutes(10))));
  faults.push_back(
      MakeTimeFault("back-5s", "clock set back by 5 s", 0.0, Shifting(std::chrono::seconds(-5))));
  faults.push_back(MakeTimeFault("forward-5s", "clock set forward by 5 s", 0.0,
                                 Shifting(std::chrono::seconds(5))));
}

void AddLateness(std::vector<Fault>& faults) {
  for (const int late_ms : {60, 250}) {
    faults.push_back(MakeTimeFault(
        absl::StrCat("late-", late_ms, "ms"),
        absl::StrCat("one radar arrives ", late_ms, " ms late"), std::nullopt,
        [=](Stream& stream, const Window& window, std::uint64_t) {
          DelayArrival(stream, window, stream.rig.radars.front().id, milliseconds(late_ms));
        }));
    faults.back().min_radars = 2;
  }
  faults.push_back(
      MakeTimeFault("late-others-200ms", "all radars but one arrive 200 ms late", std::nullopt,
                    [](Stream& stream, const Window& window, std::uint64_t) {
                      for (std::size_t i = 1; i < stream.rig.radars.size(); ++i) {
                        DelayArrival(stream, window, stream.rig.radars[i].id, milliseconds(200));
                      }
                    }));
  faults.back().min_radars = 3;
  faults.push_back(MakeTimeFault("jitter-250ms", "every scan arrives up to 250 ms late",
                                 std::nullopt,
                                 [](Stream& stream, const Window& window, std::uint64_t seed) {
                                   JitterArrival(stream, window, milliseconds(250), seed);
                                 }));
  faults.push_back(MakeTimeFault("duplicates", "each tenth scan arrives twice", std::nullopt,
                                 [](Stream& stream, const Window& window, std::uint64_t) {
                                   DuplicateScans(stream, window, 10);
                                 }));
}

void AddStampsAndRates(std::vector<Fault>& faults) {
  faults.push_back(MakeTimeFault("coarse-50ms", "stamps rounded to 50 ms", std::nullopt,
                                 [](Stream& stream, const Window& window, std::uint64_t) {
                                   RoundStamps(stream, window, milliseconds(50));
                                 }));
  faults.push_back(MakeTimeFault(
      "aligned", "one stamp for all radars of a cycle", std::nullopt,
      [](Stream& stream, const Window& window, std::uint64_t) { AlignStamps(stream, window); }));
  faults.back().min_radars = 2;
  for (const int rate_hz : {2, 4}) {
    faults.push_back(MakeTimeFault(absl::StrCat("rate-", rate_hz, "hz"),
                                   absl::StrCat(rate_hz, " scans a second of each radar"),
                                   std::nullopt,
                                   [=](Stream& stream, const Window& window, std::uint64_t) {
                                     ThinScans(stream, window, rate_hz);
                                   }));
    faults.back().begin_s = 0.0;
  }
}

}  // namespace

void ShiftStamps(Stream& stream, const Window& window, nanoseconds shift,
                 const std::optional<std::string>& radar_id) {
  for (StreamScan& entry : stream.scans) {
    if (!window.Contains(entry.measured)) continue;
    if (!radar_id || entry.scan.radar_id == *radar_id) entry.scan.stamp += shift;
  }
}

void DelayArrival(Stream& stream, const Window& window, const std::string& radar_id,
                  nanoseconds delay) {
  for (StreamScan& entry : stream.scans) {
    const bool is_late = window.Contains(entry.measured) && entry.scan.radar_id == radar_id;
    if (is_late) entry.arrived += delay;
  }
  OrderByArrival(stream);
}

void JitterArrival(Stream& stream, const Window& window, nanoseconds max_delay,
                   std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<nanoseconds::rep> delay_ns(0, max_delay.count());
  for (StreamScan& entry : stream.scans) {
    if (window.Contains(entry.measured)) entry.arrived += nanoseconds(delay_ns(random));
  }
  OrderByArrival(stream);
}

void DuplicateScans(Stream& stream, const Window& window, std::size_t interval) {
  std::vector<StreamScan> scans;
  std::size_t count = 0;
  for (StreamScan& entry : stream.scans) {
    const bool is_twice = window.Contains(entry.measured) && count++ % interval == 0;
    if (is_twice) scans.push_back(entry);
    scans.push_back(std::move(entry));
  }
  stream.scans = std::move(scans);
}

void RoundStamps(Stream& stream, const Window& window, nanoseconds step) {
  if (stream.scans.empty()) return;
  const Stamp origin = stream.scans.front().scan.stamp;
  for (StreamScan& entry : stream.scans) {
    if (!window.Contains(entry.measured)) continue;
    const nanoseconds since = entry.scan.stamp - origin + step / 2;
    entry.scan.stamp = origin + since / step * step;
  }
}

void AlignStamps(Stream& stream, const Window& window) {
  std::optional<Stamp> cycle;
  for (StreamScan& entry : stream.scans) {
    if (!window.Contains(entry.measured)) continue;
    if (entry.scan.radar_id == stream.rig.radars.front().id) cycle = entry.scan.stamp;
    if (cycle) entry.scan.stamp = *cycle;
  }
}

void ThinScans(Stream& stream, const Window& window, double rate_hz) {
  const nanoseconds period = Duration((1.0 - kRateTolerance) / rate_hz);
  std::map<std::string, Stamp> kept;
  std::erase_if(stream.scans, [&](const StreamScan& entry) {
    if (!window.Contains(entry.measured)) return false;
    const auto [last, is_first] = kept.try_emplace(entry.scan.radar_id, entry.measured);
    if (is_first) return false;
    if (entry.measured - last->second < period) return true;
    last->second = entry.measured;
    return false;
  });
}

std::vector<Fault> TimeFaults() {
  std::vector<Fault> faults;
  AddClocks(faults);
  AddLateness(faults);
  AddStampsAndRates(faults);
  return faults;
}

}  // namespace dcloc::faults
