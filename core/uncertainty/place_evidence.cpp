#include "core/uncertainty/place_evidence.h"

#include <algorithm>
#include <cmath>

namespace dcloc {

std::span<const OptionField<PlaceEvidenceOptions>> FieldsOf(
    const PlaceEvidenceOptions& /*options*/) {
  using O = PlaceEvidenceOptions;
  static constexpr OptionField<O> kFields[] = {
      {"time_constant_ms", &O::time_constant, 1, 1e6},
      {"mapped_m", &O::mapped_m, 1e-3, 1000},
      {"min_point_count", &O::min_point_count, 1, 100'000},
      {"min_fit", &O::min_fit, 0, 1, "only innovations speak against a place"},
      {"fit_per_innovation", &O::fit_per_innovation, 0, 1, "the fit alone decides"},
      {"max_innovation", &O::max_innovation, 1, 1e6},
      {"supposed_innovations", &O::supposed_innovations, 0, 1e6, "the first registration decides"},
      {"fit_per_lost_claim", &O::fit_per_lost_claim, 0, 1, "claims that were lost say nothing"},
      {"max_lost_claims", &O::max_lost_claims, 0, 100, "likewise"},
      {"verified_distance_m", &O::verified_distance_m, 0, 1e6, "each search counts"},
      {"lost_claim_time_constant_ms", &O::lost_claim_time_constant, 1, 1e7},
      {"regained_fit", &O::regained_fit, 0, 1, "there is no hysteresis"},
  };
  return kFields;
}

absl::Status Validate(const PlaceEvidenceOptions& options) {
  return ValidateFields(options, FieldsOf(options));
}

void PlaceEvidence::FadingMean::Add(Stamp stamp, double value, double its_weight,
                                    std::chrono::nanoseconds time_constant) {
  const double keep =
      last ? std::exp(-std::max(0.0, SecondsOf(stamp - *last)) / SecondsOf(time_constant)) : 1.0;
  sum = keep * sum + its_weight * value;
  weight = keep * weight + its_weight;
  last = stamp;
}

void PlaceEvidence::Reset() {
  PlaceEvidence begun(options_);
  begun.lost_claims_ = lost_claims_;
  begun.claimed_last_ = claimed_last_;
  *this = begun;
}

void PlaceEvidence::OnClaim(Stamp stamp, bool is_claimed, bool is_lost) {
  if (is_claimed) {
    if (claimed_last_) {
      lost_claims_ *= std::exp(-std::max(0.0, SecondsOf(stamp - *claimed_last_)) /
                               SecondsOf(options_.lost_claim_time_constant));
    }
    claimed_last_ = stamp;
  } else if (is_lost && claimed_last_) {
    if (verdict_ == EvidenceForPlace::kLacking) {
      lost_claims_ = std::min(lost_claims_ + 1.0, options_.max_lost_claims);
    }
    claimed_last_.reset();
  }
}

void PlaceEvidence::OnVerified(const Eigen::Vector2d& position_m) {
  if (verified_m_ && (position_m - *verified_m_).norm() < options_.verified_distance_m) return;
  if (verified_m_) lost_claims_ = std::max(0.0, lost_claims_ - 1.0);
  verified_m_ = position_m;
  Update();
}

void PlaceEvidence::OnScanFit(Stamp stamp, std::size_t point_count, double fit) {
  if (point_count == 0) return;
  fit_.Add(stamp, fit, static_cast<double>(point_count), options_.time_constant);
  point_count_ += point_count;
  Update();
}

void PlaceEvidence::OnInnovation(Stamp stamp, double squared_distance_per_dof) {
  innovation_.Add(stamp, std::min(squared_distance_per_dof, options_.max_innovation), 1.0,
                  options_.time_constant);
  Update();
}

void PlaceEvidence::Update() {  // METHOD eq 69
  if (point_count_ < static_cast<std::size_t>(options_.min_point_count)) return;
  double least = options_.min_fit + options_.fit_per_innovation * innovation_.Value() +
                 options_.fit_per_lost_claim * lost_claims_;
  if (verdict_ == EvidenceForPlace::kLacking) least += options_.regained_fit;
  verdict_ = fit_.Value() >= least ? EvidenceForPlace::kEnough : EvidenceForPlace::kLacking;
}

}  // namespace dcloc
