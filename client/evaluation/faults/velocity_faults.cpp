#include "client/evaluation/faults/velocity_faults.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "client/simulation/simulation_options.h"
#include "core/geometry/degrees.h"

namespace dcloc::faults {
namespace {

constexpr double kRamp_s = 20.0;

/// `change` is also told since when the fault is in force.
template <typename Change>
void ChangeVelocitiesOverTime(Stream& stream, const Window& window, const Change& change) {
  for (StreamScan& entry : stream.scans) {
    if (window.Contains(entry.measured) && entry.scan.ego_velocity) {
      change(*entry.scan.ego_velocity,
             std::chrono::duration<double>(entry.measured - window.begin).count());
    }
  }
}

template <typename Change>
void ChangeVelocities(Stream& stream, const Window& window, const Change& change) {
  ChangeVelocitiesOverTime(stream, window,
                           [&](EgoVelocity& velocity, double /*since_s*/) { change(velocity); });
}

/// A reported velocity and when it was true.
struct TimedVelocity {
  Stamp stamp;
  EgoVelocity velocity;
};

std::vector<TimedVelocity> VelocitiesOf(const Stream& stream) {
  std::vector<TimedVelocity> log;
  for (const StreamScan& entry : stream.scans) {
    if (entry.scan.ego_velocity) log.push_back({entry.measured, *entry.scan.ego_velocity});
  }
  std::ranges::stable_sort(log, {}, &TimedVelocity::stamp);
  return log;
}

// Linear between the entries around `stamp`; `log` is not empty.
EgoVelocity VelocityAt(const std::vector<TimedVelocity>& log, Stamp stamp) {
  const auto next = std::ranges::lower_bound(log, stamp, {}, &TimedVelocity::stamp);
  if (next == log.begin()) return next->velocity;
  const auto previous = std::prev(next);
  if (next == log.end()) return previous->velocity;
  const double share = std::chrono::duration<double>(stamp - previous->stamp) /
                       std::chrono::duration<double>(next->stamp - previous->stamp);
  EgoVelocity velocity = previous->velocity;
  velocity.linear_mps += share * (next->velocity.linear_mps - previous->velocity.linear_mps);
  velocity.angular_radps +=
      share * (next->velocity.angular_radps - previous->velocity.angular_radps);
  return velocity;
}

Fault MakeVelocityFault(const std::string& id, std::string label, std::optional<double> duration_s,
                        Fault::Apply apply) {
  return {.id = absl::StrCat("velocity-", id),
          .family = "velocity",
          .label = std::move(label),
          .duration_s = duration_s,
          .apply = std::move(apply)};
}

Fault FromTheStart(Fault fault) {
  fault.id += "-start";
  fault.label += ", from the start";
  fault.begin_s = 0.0;
  return fault;
}

Fault::Apply Scaling(double linear_factor, double angular_factor) {
  return [=](Stream& stream, const Window& window, std::uint64_t) {
    ScaleVelocity(stream, window, linear_factor, angular_factor);
  };
}

void AddZeroAndFrozen(std::vector<Fault>& faults) {
  for (const int seconds : {1, 3, 10}) {
    faults.push_back(MakeVelocityFault(absl::StrCat("zero-", seconds, "s"),
                                       absl::StrCat("speed 0 for ", seconds, " s"), seconds,
                                       Scaling(0.0, 1.0)));
  }
  faults.push_back(
      MakeVelocityFault("zero", "speed 0 from then on", std::nullopt, Scaling(0.0, 1.0)));
  for (const int seconds : {5, 10}) {
    faults.push_back(MakeVelocityFault(absl::StrCat("frozen-", seconds, "s"),
                                       absl::StrCat("velocity frozen for ", seconds, " s"), seconds,
                                       [](Stream& stream, const Window& window, std::uint64_t) {
                                         FreezeVelocity(stream, window);
                                       }));
  }
}

// A gyroscope, or the whole bus, that is dead.
void AddDead(std::vector<Fault>& faults) {
  faults.push_back(
      MakeVelocityFault("yaw-zero", "yaw rate 0 from then on", std::nullopt, Scaling(1.0, 0.0)));
  faults.push_back(FromTheStart(faults.back()));
  faults.push_back(MakeVelocityFault("all-zero", "speed and yaw rate 0 from then on", std::nullopt,
                                     Scaling(0.0, 0.0)));
}

// Driven wheels that spin, also where the vehicle stands.
void AddSpin(std::vector<Fault>& faults) {
  faults.push_back(MakeVelocityFault(
      "spin-10s", "speed 5 m/s more for 10 s", 10.0,
      [](Stream& stream, const Window& window, std::uint64_t) { BiasSpeed(stream, window, 5.0); }));
}

void AddScales(std::vector<Fault>& faults) {
  for (const double factor : {0.5, 0.7, 0.9, 0.95, 0.98, 1.02, 1.05, 1.1, 1.3, 1.5}) {
    faults.push_back(MakeVelocityFault(absl::StrCat("scale-", factor),
                                       absl::StrCat("speed times ", factor), std::nullopt,
                                       Scaling(factor, 1.0)));
    faults.push_back(FromTheStart(faults.back()));
  }
}

// What tyres and gyroscopes do: a little, for a while, slowly.
void AddSmallScales(std::vector<Fault>& faults) {
  for (const double factor : {0.95, 1.05}) {
    Fault later = MakeVelocityFault(absl::StrCat("scale-", factor, "-30s"),
                                    absl::StrCat("speed times ", factor, ", from 30 s on"),
                                    std::nullopt, Scaling(factor, 1.0));
    later.begin_s = 30.0;
    faults.push_back(std::move(later));
    faults.push_back(MakeVelocityFault(absl::StrCat("scale-", factor, "-10s"),
                                       absl::StrCat("speed times ", factor, " for 10 s"), 10.0,
                                       Scaling(factor, 1.0)));
    faults.push_back(MakeVelocityFault(
        absl::StrCat("ramp-", factor), absl::StrCat("speed times ", factor, ", reached in 20 s"),
        std::nullopt, [=](Stream& stream, const Window& window, std::uint64_t) {
          RampSpeed(stream, window, factor, kRamp_s);
        }));
    faults.push_back(MakeVelocityFault(absl::StrCat("yaw-scale-", factor),
                                       absl::StrCat("yaw rate times ", factor), std::nullopt,
                                       Scaling(1.0, factor)));
  }
}

void AddSignsAndBiases(std::vector<Fault>& faults) {
  for (const int bias_degps : {-5, -3, -1, 1, 3, 5}) {
    faults.push_back(
        MakeVelocityFault(absl::StrCat("yaw-bias", bias_degps < 0 ? "" : "+", bias_degps),
                          absl::StrCat("yaw rate off by ", bias_degps, " deg/s"), std::nullopt,
                          [=](Stream& stream, const Window& window, std::uint64_t) {
                            BiasYawRate(stream, window, bias_degps * kRadPerDeg);
                          }));
  }
  faults.push_back(
      MakeVelocityFault("sign", "sign of the speed wrong", std::nullopt, Scaling(-1.0, 1.0)));
  Fault kmh =
      MakeVelocityFault("kmh", "speed in km/h, from the start", std::nullopt, Scaling(3.6, 1.0));
  kmh.begin_s = 0.0;
  faults.push_back(std::move(kmh));
  faults.push_back(MakeVelocityFault("yaw-sign", "sign of the yaw rate wrong", std::nullopt,
                                     Scaling(1.0, -1.0)));
  faults.push_back(MakeVelocityFault("two", "speed times 1.1, and yaw rate off by 2 deg/s",
                                     std::nullopt,
                                     [](Stream& stream, const Window& window, std::uint64_t) {
                                       ScaleVelocity(stream, window, 1.1, 1.0);
                                       BiasYawRate(stream, window, 2.0 * kRadPerDeg);
                                     }));
  Fault unsigned_speed = MakeVelocityFault(
      "unsigned", "speed without its sign for 10 s of reversing", 10.0,
      [](Stream& stream, const Window& window, std::uint64_t) { UnsignSpeed(stream, window); });
  unsigned_speed.is_reversing = true;
  faults.push_back(std::move(unsigned_speed));
}

// What many vehicles send: steps, and nothing of a speed at which the wheels' sensors see no teeth.
void AddCoarse(std::vector<Fault>& faults) {
  Fault coarse = MakeVelocityFault(
      "coarse", "speed in steps of 1 km/h, none below 2.5 km/h; yaw rate in steps of 0.5 deg/s",
      std::nullopt, [](Stream& stream, const Window& window, std::uint64_t) {
        RoundVelocity(stream, window, kMpsPerKmh, 2.5 * kMpsPerKmh, 0.5 * kRadPerDeg);
      });
  coarse.begin_s = 0.0;
  faults.push_back(std::move(coarse));
}

void AddLateAndMissing(std::vector<Fault>& faults) {
  for (const double delay_s : {0.05, 0.1, 0.2, 0.3}) {
    Fault late = MakeVelocityFault(absl::StrCat("late-", delay_s, "s"),
                                   absl::StrCat("velocity ", delay_s, " s late"), std::nullopt,
                                   [=](Stream& stream, const Window& window, std::uint64_t) {
                                     DelayVelocity(stream, window, delay_s);
                                   });
    late.begin_s = 0.0;
    faults.push_back(std::move(late));
  }
  faults.push_back(MakeVelocityFault("sparse", "velocity with every third scan alone", std::nullopt,
                                     [](Stream& stream, const Window& window, std::uint64_t) {
                                       ThinVelocity(stream, window, 3);
                                     }));
  Fault none = MakeVelocityFault(
      "none", "no velocity at all", std::nullopt,
      [](Stream& stream, const Window& window, std::uint64_t) { DropVelocity(stream, window); });
  none.begin_s = 0.0;
  faults.push_back(std::move(none));
  const auto stating = [](double factor, double sigma) {
    return [=](Stream& stream, const Window& window, std::uint64_t) {
      ScaleVelocity(stream, window, factor, 1.0);
      StateVelocitySigma(stream, window, sigma);
    };
  };
  faults.push_back(MakeVelocityFault("sure",
                                     "speed times 1.3 with a stated deviation of 1e-6 for 10 s",
                                     10.0, stating(1.3, 1e-6)));
  faults.push_back(MakeVelocityFault("unsure", "true velocity with a stated deviation of 1e6",
                                     std::nullopt, stating(1.0, 1e6)));
}

}  // namespace

void ScaleVelocity(Stream& stream, const Window& window, double linear_factor,
                   double angular_factor) {
  ChangeVelocities(stream, window, [&](EgoVelocity& velocity) {
    velocity.linear_mps *= linear_factor;
    velocity.angular_radps *= angular_factor;
  });
}

void RampSpeed(Stream& stream, const Window& window, double factor, double ramp_s) {
  ChangeVelocitiesOverTime(stream, window, [&](EgoVelocity& velocity, double since_s) {
    velocity.linear_mps *= 1.0 + (factor - 1.0) * std::min(1.0, since_s / ramp_s);
  });
}

void FreezeVelocity(Stream& stream, const Window& window) {
  const std::vector<TimedVelocity> log = VelocitiesOf(stream);
  if (log.empty()) return;
  const auto after = std::ranges::lower_bound(log, window.begin, {}, &TimedVelocity::stamp);
  const EgoVelocity& last = after == log.begin() ? after->velocity : std::prev(after)->velocity;
  ChangeVelocities(stream, window, [&](EgoVelocity& velocity) { velocity = last; });
}

void BiasSpeed(Stream& stream, const Window& window, double bias_mps) {
  ChangeVelocities(stream, window,
                   [&](EgoVelocity& velocity) { velocity.linear_mps.x() += bias_mps; });
}

void BiasYawRate(Stream& stream, const Window& window, double bias_radps) {
  ChangeVelocities(stream, window,
                   [&](EgoVelocity& velocity) { velocity.angular_radps.z() += bias_radps; });
}

void RoundVelocity(Stream& stream, const Window& window, double step_mps, double least_mps,
                   double step_radps) {
  ChangeVelocities(stream, window, [&](EgoVelocity& velocity) {
    double& speed_mps = velocity.linear_mps.x();
    speed_mps = std::abs(speed_mps) < least_mps ? 0.0 : step_mps * std::round(speed_mps / step_mps);
    double& yaw_rate_radps = velocity.angular_radps.z();
    yaw_rate_radps = step_radps * std::round(yaw_rate_radps / step_radps);
  });
}

void UnsignSpeed(Stream& stream, const Window& window) {
  ChangeVelocities(stream, window, [](EgoVelocity& velocity) {
    velocity.linear_mps.x() = std::abs(velocity.linear_mps.x());
  });
}

void DelayVelocity(Stream& stream, const Window& window, double delay_s) {
  const std::vector<TimedVelocity> log = VelocitiesOf(stream);
  for (StreamScan& entry : stream.scans) {
    if (!window.Contains(entry.measured) || !entry.scan.ego_velocity) continue;
    entry.scan.ego_velocity = VelocityAt(log, entry.measured - Duration(delay_s));
  }
}

void DropVelocity(Stream& stream, const Window& window) {
  for (StreamScan& entry : stream.scans) {
    if (window.Contains(entry.measured)) entry.scan.ego_velocity.reset();
  }
}

void ThinVelocity(Stream& stream, const Window& window, int interval) {
  int count = 0;
  for (StreamScan& entry : stream.scans) {
    if (window.Contains(entry.measured) && count++ % interval != 0) entry.scan.ego_velocity.reset();
  }
}

void StateVelocitySigma(Stream& stream, const Window& window, double sigma) {
  ChangeVelocities(stream, window, [&](EgoVelocity& velocity) {
    velocity.covariance = Matrix6d(Matrix6d::Identity() * (sigma * sigma));
  });
}

std::vector<Fault> VelocityFaults() {
  std::vector<Fault> faults;
  AddZeroAndFrozen(faults);
  AddDead(faults);
  AddSpin(faults);
  AddScales(faults);
  AddSmallScales(faults);
  AddSignsAndBiases(faults);
  AddCoarse(faults);
  AddLateAndMissing(faults);
  return faults;
}

}  // namespace dcloc::faults
