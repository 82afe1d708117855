#pragma once

#include <Eigen/Core>
#include <chrono>
#include <cstddef>
#include <optional>
#include <span>

#include "absl/status/status.h"
#include "core/options/option_fields.h"
#include "core/radar/stamp.h"

namespace dcloc {

/// When what is seen speaks for a place in the map.
struct PlaceEvidenceOptions {
  std::chrono::nanoseconds time_constant = std::chrono::seconds(1);  ///< older scans count less
  double mapped_m = 5.0;     ///< a point counts where the map has a landmark within this
  int min_point_count = 30;  ///< points seen at a place before anything is said
  /// The least fit of scans. At a true place it is 0.5 times the share of points that the map has;
  /// at a wrong one some points fit by chance.
  double min_fit = 0.2;
  /// By how much more it must be for each unit of the mean innovation: where registrations scatter
  /// about the motion more than they should, a fit by chance is more probable.
  double fit_per_innovation = 0.1;
  double max_innovation = 10.0;  ///< the most that one innovation counts for
  /// A place begins as if it had so many innovations of 1: few registrations agree by chance.
  double supposed_innovations = 3.0;
  double regained_fit = 0.03;  ///< by so much it must exceed the least, once it was too low
  /// By how much more it must be for each place that was claimed and then lost for lack of
  /// evidence: the map may be another one.
  double fit_per_lost_claim = 0.06;
  double max_lost_claims = 3.0;  ///< the most that count
  /// A search that finds no better place takes one of them back, if it is so far from the last one
  /// that did.
  double verified_distance_m = 10.0;
  /// A lost claim counts less the longer another one holds.
  std::chrono::nanoseconds lost_claim_time_constant = std::chrono::seconds(60);
};
std::span<const OptionField<PlaceEvidenceOptions>> FieldsOf(const PlaceEvidenceOptions& options);
absl::Status Validate(const PlaceEvidenceOptions& options);

/// Whether what is seen speaks for the place where the vehicle is supposed to be: that little was
/// seen there or that the place does not stand out, that it does, that it does not.
enum class EvidenceForPlace { kTooLittle, kEnough, kLacking };

/// Tells a place in the map from one that fits by chance, as in the map of another street, or of
/// one that was rebuilt (METHOD eq 69). There, registrations go on to find a pose that fits best,
/// but scans fit it less than a true one, and registrations do not agree with the motion. Either
/// alone has other causes: a sparse map, or odometry that is wrong.
class PlaceEvidence {
 public:
  explicit PlaceEvidence(const PlaceEvidenceOptions& options)
      : options_(options),
        innovation_{.sum = options.supposed_innovations, .weight = options.supposed_innovations} {}

  /// A scan at `stamp` with `point_count` static points where the map has landmarks fits it so at
  /// the predicted pose, [0, 1]; the last registration was accepted.
  void OnScanFit(Stamp stamp, std::size_t point_count, double fit);

  /// A registration at `stamp` differed so from its prediction: squared Mahalanobis distance per
  /// degree of freedom.
  void OnInnovation(Stamp stamp, double squared_distance_per_dof);

  /// At `stamp` the place is claimed, or has been given up as lost, or neither.
  void OnClaim(Stamp stamp, bool is_claimed, bool is_lost);

  /// A search has found that no place around fits better than this one, and that views fit it as
  /// they usually did.
  void OnVerified(const Eigen::Vector2d& position_m);

  /// The vehicle is supposed to be at another place of the same map.
  void Reset();

  EvidenceForPlace Judge() const { return verdict_; }

 private:
  // A mean of which older values fade.
  struct FadingMean {
    double sum = 0.0;
    double weight = 0.0;
    std::optional<Stamp> last;

    void Add(Stamp stamp, double value, double its_weight, std::chrono::nanoseconds time_constant);
    double Value() const { return weight > 0.0 ? sum / weight : 0.0; }
  };
  void Update();

  PlaceEvidenceOptions options_;
  FadingMean fit_;  // over points
  FadingMean innovation_;
  std::size_t point_count_ = 0;
  EvidenceForPlace verdict_ = EvidenceForPlace::kTooLittle;
  double lost_claims_ = 0.0;  // places that did not hold; they fade while one does
  std::optional<Eigen::Vector2d> verified_m_;
  std::optional<Stamp> claimed_last_;  // while a place is claimed, or was until now
};

}  // namespace dcloc
