#include <cstdlib>
#include <string>

#include "tests/core/localizer/on_a_road.h"

namespace dcloc {
namespace {

// Scans that are valid, half valid or neither, of a vehicle whose every input may lie.
class Adversary {
 public:
  Adversary(const std::vector<TrueScan>& drive, unsigned seed) : drive_(drive), random_(seed) {}

  Scan Next() {
    Scan scan = drive_[next_++ % drive_.size()].scan;
    scan.stamp = now_;
    now_ += std::chrono::milliseconds(Pick(100));
    if (Once(10)) now_ += std::chrono::milliseconds(Pick(700) - 350);
    if (Once(300)) now_ += std::chrono::seconds(Pick(2'000'000) - 1'000'000);
    if (Once(2000)) now_ = Stamp(std::chrono::nanoseconds(Pick(1 << 30)));
    if (Once(5)) scan.radar_id = Once(20) ? "nobody" : "second";
    if (Once(12)) scan.ego_velocity.reset();
    if (Once(8)) Lie(*Velocity(scan));
    if (Once(10)) Spoil(scan);
    if (Once(20)) Flood(scan);
    if (Once(15)) Thin(scan);
    if (Once(25)) scan = previous_;
    previous_ = scan;
    return scan;
  }

 private:
  int Pick(int count) { return std::uniform_int_distribution<int>(0, count - 1)(random_); }
  bool Once(int in) { return Pick(in) == 0; }
  double Extreme() {
    static constexpr double kValues[] = {0.0,  1e-30, -1e-30, 1e-6, -1e-6, 0.5,  -3.0,
                                         30.0, -150,  150.0,  1e6,  1e30,  -1e30};
    return kValues[Pick(static_cast<int>(std::size(kValues)))];
  }

  static EgoVelocity* Velocity(Scan& scan) {
    if (!scan.ego_velocity) scan.ego_velocity = EgoVelocity{};
    return &*scan.ego_velocity;
  }

  void Lie(EgoVelocity& velocity) {
    for (int i = 0; i < 3; ++i) {
      if (Once(2)) velocity.linear_mps(i) = Extreme();
      if (Once(3)) velocity.angular_radps(i) = Extreme() / 15.0;
    }
    if (Once(2)) velocity.covariance = Matrix6d(std::abs(Extreme()) * Matrix6d::Identity());
  }

  void Spoil(Scan& scan) {
    const auto spoil = [&](std::vector<float>& column) {
      if (column.empty() || !Once(3)) return;
      for (int i = 0; i < 5; ++i) {
        column[static_cast<std::size_t>(Pick(static_cast<int>(column.size())))] =
            static_cast<float>(Extreme());
      }
    };
    spoil(scan.range_m);
    spoil(scan.range_rate_mps);
    spoil(scan.azimuth_rad);
    if (Once(3)) scan.range_sigma_m.assign(scan.size(), static_cast<float>(Extreme()));
    if (Once(3)) scan.azimuth_sigma_rad.assign(scan.size(), static_cast<float>(Extreme()));
    if (Once(3)) scan.range_rate_sigma_mps.assign(scan.size(), static_cast<float>(Extreme()));
    if (Once(9)) scan.azimuth_rad.pop_back();
  }

  // Thousands of targets, at one place or anywhere.
  void Flood(Scan& scan) {
    const bool at_one_place = Once(2);
    for (int i = Pick(3000); i > 0; --i) {
      scan.range_m.push_back(at_one_place ? 12.0F : static_cast<float>(1 + Pick(200)));
      scan.range_rate_mps.push_back(static_cast<float>(Pick(60) - 30));
      scan.azimuth_rad.push_back(at_one_place ? 0.1F : static_cast<float>(Pick(600)) / 100 - 3);
    }
  }

  void Thin(Scan& scan) {
    const auto count = static_cast<std::size_t>(Pick(4));
    for (auto* column : {&scan.range_m, &scan.range_rate_mps, &scan.azimuth_rad}) {
      column->resize(std::min(column->size(), count));
    }
  }

  const std::vector<TrueScan>& drive_;
  std::mt19937 random_;
  std::size_t next_ = 0;
  Stamp now_{std::chrono::seconds(1'700'000'000)};
  Scan previous_;
};

int ScanCount() {
  const char* count = std::getenv("DCLOC_PROPERTY_SCANS");
  return count == nullptr ? 6000 : std::stoi(count);
}

using LocalizerPropertyTest = OnARoad;

// DCLOC_PROPERTY_SCANS says how many.
TEST_F(LocalizerPropertyTest, WhateverIsSentAnAnswerIsFiniteOrARefusal) {
  Rig rig = FrontRadar();
  rig.radars.push_back(rig.radars[0]);
  rig.radars[1].id = "second";
  constexpr int kSessionScans = 2000;
  int answered = 0;
  for (int begin = 0; begin < ScanCount(); begin += kSessionScans) {
    const auto seed = static_cast<unsigned>(begin / kSessionScans);
    Adversary adversary(drive_, seed);
    std::optional<InitialPose> prior;
    if (seed % 3 != 0) prior = PriorAt(Start(), seed % 3 == 1 ? 0.3 : 30.0, 0.05);
    Localizer localizer = MakeLocalizer(map_, rig, prior);
    for (int i = 0; i < std::min(kSessionScans, ScanCount() - begin); ++i) {
      const auto answer = localizer.Localize(adversary.Next());
      if (!answer.ok()) {
        ASSERT_EQ(answer.status().code(), absl::StatusCode::kInvalidArgument);
        continue;
      }
      ++answered;
      ASSERT_TRUE(answer->T_map_vehicle.translation_m.allFinite()) << seed << ", scan " << i;
      ASSERT_NEAR(answer->T_map_vehicle.rotation.norm(), 1.0, 1e-6) << seed << ", scan " << i;
      ASSERT_TRUE(answer->covariance.allFinite()) << seed << ", scan " << i;
    }
  }
  EXPECT_GT(answered, ScanCount() / 2);
}

}  // namespace
}  // namespace dcloc
