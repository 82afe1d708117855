#include "core/versions/judged_version.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "client/datasets/drive_map.h"
#include "client/simulation/simulation.h"

namespace dcloc {
namespace {

bool HasPointsOf(const EditableKeyframe& a, const EditableKeyframe& b) {
  if (a.points.size() != b.points.size()) return false;
  return a.points.empty() ||
         std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof(MapPoint)) == 0;
}

/// A street, of which the old version has the first part, and a drive through all of it.
class JudgedVersionTest : public ::testing::Test {
 protected:
  JudgedVersionTest() {
    SimulationOptions options;
    options.seed = 3;
    options.length_m = 400.0;
    const Drive map_drive = SimulatePass(options, Passes(options)[0]).value();
    const Drive held_out = SimulatePass(options, Passes(options)[1]).value();
    whole_ =
        ToEditable(*RadarMap::FromBytes(BuildMap(map_drive, {.name = "town"}).value()).value());
    old_ = whole_;
    old_.keyframes.resize(whole_.keyframes.size() / 2);
    rig_ = held_out.rig;
    for (const DriveScan& entry : held_out.scans) scans_.push_back(entry.scan);
  }

  static void MoveAside(EditableMap& map, std::size_t begin, std::size_t end, float offset_m) {
    for (std::size_t k = begin; k < end; ++k) {
      for (MapPoint& point : map.keyframes[k].points) point.y_m += offset_m;
    }
  }

  JudgedVersion Judged(const EditableMap& new_version) const {
    auto version = JudgeVersion(old_, {.map = new_version}, rig_, scans_);
    EXPECT_TRUE(version.ok()) << version.status();
    return *std::move(version);
  }

  EditableMap whole_, old_;
  Rig rig_;
  std::vector<Scan> scans_;
};

TEST_F(JudgedVersionTest, WhatIsBetterIsTakenAsItIs) {
  const JudgedVersion version = Judged(whole_);
  EXPECT_TRUE(version.evaluation.is_better) << version.evaluation.reason;
  EXPECT_FALSE(version.has_only_new_streets);
  EXPECT_EQ(version.map.keyframes.size(), whole_.keyframes.size());
}

TEST_F(JudgedVersionTest, NewStreetsAreTakenAloneWhereTheRestIsWorse) {
  EditableMap bent = whole_;
  MoveAside(bent, 0, old_.keyframes.size() / 2, 0.5F);
  const JudgedVersion version = Judged(bent);
  EXPECT_TRUE(version.evaluation.is_better) << version.evaluation.reason;
  EXPECT_TRUE(version.has_only_new_streets);
  ASSERT_EQ(version.map.keyframes.size(), whole_.keyframes.size());
  for (std::size_t k = 0; k < whole_.keyframes.size(); ++k) {
    EXPECT_TRUE(HasPointsOf(version.map.keyframes[k], whole_.keyframes[k])) << k;
    EXPECT_EQ(version.is_kept[k], k >= old_.keyframes.size()) << k;
  }
}

TEST_F(JudgedVersionTest, ANewStreetThatLiesElsewhereIsLeftOut) {
  EditableMap bent = whole_;
  MoveAside(bent, old_.keyframes.size(), bent.keyframes.size(), 4.0F);
  const JudgedVersion version = Judged(bent);
  EXPECT_FALSE(version.evaluation.is_better &&
               version.map.keyframes.size() == whole_.keyframes.size());
}

TEST_F(JudgedVersionTest, WithoutNewStreetsARefusedVersionIsRefused) {
  EditableMap bent = old_;
  MoveAside(bent, 0, bent.keyframes.size() / 2, 0.5F);
  const JudgedVersion version = Judged(bent);
  EXPECT_FALSE(version.evaluation.is_better);
  EXPECT_FALSE(version.has_only_new_streets);
}

}  // namespace
}  // namespace dcloc
