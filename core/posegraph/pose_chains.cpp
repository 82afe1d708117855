#include "core/posegraph/pose_chains.h"

#include <algorithm>
#include <utility>

namespace dcloc {

template <int Dim>
void PoseChains<Dim>::Clear() {
  accepted_chain_ = PoseGraph<Dim>(options_);
  alternative_.reset();
}

template <int Dim>
void PoseChains<Dim>::Reset(const PoseEstimate<Dim>& prior, const TangentMatrix<Dim>& systematic) {
  accepted_chain_.Reset(prior, systematic);
  alternative_.reset();
}

template <int Dim>
void PoseChains<Dim>::AddState(const PoseEstimate<Dim>& odometry,
                               const TangentMatrix<Dim>& noise_covariance) {
  accepted_chain_.AddState(odometry, noise_covariance);
  if (alternative_) alternative_->AddState(odometry, noise_covariance);
}

template <int Dim>
void PoseChains<Dim>::ChangeFrame(const Pose<Dim>& T_new_old) {
  accepted_chain_.ChangeFrame(T_new_old);
  if (alternative_) alternative_->ChangeFrame(T_new_old);
}

template <int Dim>
InnovationTest PoseChains<Dim>::AddAbsolutePose(const AbsolutePoseFactor<Dim>& factor) {
  InnovationTest test = accepted_chain_.AddAbsolutePose(factor);
  if (test.is_accepted) {
    alternative_.reset();
    accepted_chain_.Solve();
    return test;
  }
  UpdateAlternative(factor, test.squared_distance);
  if (support_ >= support_needed_) {
    accepted_chain_ = *std::exchange(alternative_, std::nullopt);
    test.is_accepted = true;
  }
  return test;
}

template <int Dim>
InnovationTest PoseChains<Dim>::AddPosition(const AbsolutePoseFactor<Dim>& factor) {
  const InnovationTest test = accepted_chain_.AddAbsolutePose(factor);
  if (!test.is_accepted) return test;
  alternative_.reset();
  accepted_chain_.Solve();
  return test;
}

template <int Dim>
void PoseChains<Dim>::UpdateAlternative(const AbsolutePoseFactor<Dim>& factor,
                                        double squared_distance) {
  if (alternative_ && alternative_->AddAbsolutePose(factor).is_accepted) {
    alternative_->Solve();
    ++support_;
    return;
  }
  alternative_.emplace(options_);
  alternative_->Reset({.pose = factor.pose, .covariance = factor.weight_covariance},
                      factor.systematic);
  support_ = 1;
  support_needed_ = squared_distance <= options_.near_squared_distance
                        ? std::min(options_.near_takeover_support, options_.takeover_support)
                        : options_.takeover_support;
}

template class PoseChains<2>;
template class PoseChains<3>;

}  // namespace dcloc
