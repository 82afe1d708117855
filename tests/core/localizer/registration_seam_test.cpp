#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "core/registration/gicp_registration.h"
#include "tests/core/localizer/synthetic_world.h"

namespace dcloc {
namespace {

// Somebody else's method: it leaves nothing in the workspace.
class ForeignMethod final : public RegistrationMethod<2> {
 public:
  Registration<2> Register(const RegistrationInput<2>& input,
                           RegistrationWorkspace<2>& /*workspace*/) const override {
    ++calls;
    GicpOptions options;
    options.initial_blur_m = input.guess_sigma_m;
    return RegisterGicp<2>(input.points, input.map, input.T_local_vehicle_guess, options);
  }
  mutable int calls = 0;
};

// One that returns the guess, without a correspondence.
class GuessMethod final : public RegistrationMethod<2> {
 public:
  Registration<2> Register(const RegistrationInput<2>& input,
                           RegistrationWorkspace<2>& /*workspace*/) const override {
    return {.T_local_vehicle = input.T_local_vehicle_guess,
            .covariance = TangentMatrix<2>::Identity() * 1e-4,
            .inlier_count = 0};
  }
};

class RegistrationSeamTest : public ::testing::Test {
 protected:
  std::vector<TrueAnswer> Localize(std::shared_ptr<const RegistrationMethod<2>> method) const {
    auto localizer =
        Localizer::Create(map_, FrontRadar(), PriorAt(drive_.front().T_map_vehicle, 0.3, 0.02), {},
                          {.planar = std::move(method), .spatial = nullptr});
    EXPECT_TRUE(localizer.ok()) << localizer.status();
    return LocalizeDrive(*std::move(localizer), drive_);
  }

  const SyntheticWorld world_;
  const std::shared_ptr<const RadarMap> map_ =
      MapOfDrive(DriveRoad(world_, FrontRadar(), 8.0, 1), FrontRadar());
  const std::vector<TrueScan> drive_ = DriveRoad(world_, FrontRadar(), 14.0, 2);
};

int TrackingCount(const std::vector<TrueAnswer>& answers) {
  return static_cast<int>(std::ranges::count_if(answers, &TrueAnswer::tracking));
}

TEST_F(RegistrationSeamTest, AForeignMethodComesInWithoutThePipeline) {
  const auto foreign = std::make_shared<ForeignMethod>();
  const std::vector<TrueAnswer> answers = Localize(foreign);
  EXPECT_GT(foreign->calls, 20);
  EXPECT_GT(TrackingCount(answers), 20);
  for (const TrueAnswer& answer : answers) {
    EXPECT_TRUE(!answer.tracking() || answer.position_error_m() < 0.5);
  }
}

TEST_F(RegistrationSeamTest, AMethodThatFindsNoInlierNeverTracks) {
  EXPECT_EQ(TrackingCount(Localize(std::make_shared<GuessMethod>())), 0);
}

TEST_F(RegistrationSeamTest, OursIsTheDefault) {
  const std::vector<TrueAnswer> ours = Localize(nullptr);
  const std::vector<TrueAnswer> same =
      Localize(std::make_shared<GicpRegistration<2>>(LocalizerOptions().matcher.gicp));
  ASSERT_EQ(ours.size(), same.size());
  for (std::size_t i = 0; i < ours.size(); ++i) {
    ExpectSame(ours[i].localization, same[i].localization);
  }
}

}  // namespace
}  // namespace dcloc
