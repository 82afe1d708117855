#include "core/uncertainty/place_evidence.h"

#include <gtest/gtest.h>

namespace dcloc {
namespace {

constexpr PlaceEvidenceOptions kOptions;

Stamp At(int ms) { return Stamp(std::chrono::hours(1)) + std::chrono::milliseconds(ms); }

/// Ten scans a second, from `from_ms` to before `to_ms`, each with a registration.
void Drive(PlaceEvidence& evidence, int from_ms, int to_ms, double fit, double innovation) {
  for (int ms = from_ms; ms < to_ms; ms += 100) {
    evidence.OnScanFit(At(ms), 30, fit);
    evidence.OnInnovation(At(ms), innovation);
  }
}

TEST(PlaceEvidenceTest, NothingIsSaidOfFewPoints) {
  PlaceEvidence evidence(kOptions);
  evidence.OnScanFit(At(0), 0, 0.0);
  evidence.OnScanFit(At(100), 20, 0.6);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kTooLittle);
  evidence.OnScanFit(At(200), 20, 0.6);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
}

TEST(PlaceEvidenceTest, ScansThatFitWellSpeakForAPlaceWhateverOdometryDoes) {
  PlaceEvidence evidence(kOptions);
  Drive(evidence, 0, 3000, 0.5, 2.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
}

TEST(PlaceEvidenceTest, ScansThatFitALittleDoWhereRegistrationsAgreeWithTheMotion) {
  PlaceEvidence evidence(kOptions);
  Drive(evidence, 0, 3000, 0.3, 0.1);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
  Drive(evidence, 3000, 6000, 0.3, 1.5);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kLacking);
}

TEST(PlaceEvidenceTest, ScansThatHardlyFitNeverDo) {
  PlaceEvidence evidence(kOptions);
  Drive(evidence, 0, 3000, 0.15, 0.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kLacking);
}

TEST(PlaceEvidenceTest, ItIsLostWithinASecondAndComesBackWithHysteresis) {
  PlaceEvidence evidence(kOptions);
  Drive(evidence, 0, 5000, 0.55, 0.1);
  Drive(evidence, 5000, 6500, 0.1, 3.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kLacking);
  const double least = kOptions.min_fit + 0.1 * kOptions.fit_per_innovation;
  Drive(evidence, 6500, 16500, least + 0.5 * kOptions.regained_fit, 0.1);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kLacking);
  Drive(evidence, 16500, 26500, least + 2.0 * kOptions.regained_fit, 0.1);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
}

TEST(PlaceEvidenceTest, APlaceBeginsAsIfRegistrationsHadErredAsMuchAsTheySay) {
  const double fit = kOptions.min_fit + 0.5 * kOptions.fit_per_innovation;
  PlaceEvidence evidence(kOptions);
  Drive(evidence, 0, 300, fit, 0.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kLacking);
  Drive(evidence, 300, 3000, fit, 0.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
  evidence.Reset();
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kTooLittle);
  Drive(evidence, 3000, 3300, fit, 0.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kLacking);
}

/// A place is claimed for a second, and then lost as its scans do not fit.
void LoseAClaim(PlaceEvidence& evidence, int from_ms) {
  Drive(evidence, from_ms, from_ms + 1000, 0.5, 0.5);
  evidence.OnClaim(At(from_ms + 1000), /*is_claimed=*/true, /*is_lost=*/false);
  Drive(evidence, from_ms + 1000, from_ms + 3000, 0.1, 3.0);
  evidence.OnClaim(At(from_ms + 3000), /*is_claimed=*/false, /*is_lost=*/true);
  evidence.Reset();
}

TEST(PlaceEvidenceTest, AfterClaimsThatWereLostMoreMustSpeakForAPlace) {
  const double fit =
      kOptions.min_fit + kOptions.fit_per_innovation + 0.5 * kOptions.fit_per_lost_claim;
  PlaceEvidence evidence(kOptions);
  Drive(evidence, 0, 1000, fit, 1.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
  LoseAClaim(evidence, 1000);
  Drive(evidence, 5000, 6000, fit, 1.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kLacking);
  for (int i = 1; i < 20; ++i) LoseAClaim(evidence, 10'000 * i);
  const double most = kOptions.min_fit + kOptions.fit_per_innovation +
                      kOptions.max_lost_claims * kOptions.fit_per_lost_claim;
  Drive(evidence, 300'000, 301'000, most + 0.01, 1.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough) << "a true place is never out of reach";
}

TEST(PlaceEvidenceTest, AClaimThatHoldsLetsLostOnesBeForgotten) {
  const double fit =
      kOptions.min_fit + kOptions.fit_per_innovation + 0.5 * kOptions.fit_per_lost_claim;
  PlaceEvidence evidence(kOptions);
  LoseAClaim(evidence, 0);
  for (int s = 10; s < 200; ++s) evidence.OnClaim(At(1000 * s), true, false);
  Drive(evidence, 200'000, 201'000, fit, 1.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
}

TEST(PlaceEvidenceTest, APlaceThatStandsOutAgainFurtherOnTakesBackALostClaim) {
  const double fit =
      kOptions.min_fit + kOptions.fit_per_innovation + 0.7 * kOptions.fit_per_lost_claim;
  PlaceEvidence evidence(kOptions);
  LoseAClaim(evidence, 0);
  evidence.OnVerified({100.0, 0.0});
  evidence.OnVerified({100.0 + 0.9 * kOptions.verified_distance_m, 0.0});  // nearly the same view
  Drive(evidence, 10'000, 13'000, fit, 1.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kLacking);
  evidence.OnVerified({100.0 + 1.1 * kOptions.verified_distance_m, 0.0});
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
}

TEST(PlaceEvidenceTest, APlaceThatWasNeverClaimedOrThatFitToTheLastIsNoLostClaim) {
  const double fit =
      kOptions.min_fit + kOptions.fit_per_innovation + 0.5 * kOptions.fit_per_lost_claim;
  PlaceEvidence evidence(kOptions);
  Drive(evidence, 0, 2000, 0.1, 3.0);
  evidence.OnClaim(At(2000), false, true);
  Drive(evidence, 10'000, 12'000, 0.5, 0.5);
  evidence.OnClaim(At(12'000), true, false);
  evidence.OnClaim(At(12'100), false, true);  // as where nothing is seen
  evidence.Reset();
  Drive(evidence, 20'000, 21'000, fit, 1.0);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
}

TEST(PlaceEvidenceTest, OneWildInnovationCountsForNoMoreThanItsBound) {
  PlaceEvidence evidence(kOptions);
  Drive(evidence, 0, 5000, 0.55, 0.1);
  evidence.OnInnovation(At(5000), 1e12);
  EXPECT_EQ(evidence.Judge(), EvidenceForPlace::kEnough);
}

TEST(PlaceEvidenceTest, OptionsAreChecked) {
  EXPECT_TRUE(Validate(kOptions).ok());
  PlaceEvidenceOptions wrong;
  wrong.min_fit = 1.5;
  EXPECT_FALSE(Validate(wrong).ok());
}

}  // namespace
}  // namespace dcloc
