#include "core/posegraph/pose_hypotheses.h"

#include <utility>

namespace dcloc {

template <int Dim>
void PoseHypotheses<Dim>::Clear() {
  believed_ = PoseGraph<Dim>(options_);
  contender_.reset();
}

template <int Dim>
void PoseHypotheses<Dim>::Reset(const PoseEstimate<Dim>& prior, const TangentMatrix<Dim>& lasting) {
  believed_.Reset(prior, lasting);
  contender_.reset();
}

template <int Dim>
void PoseHypotheses<Dim>::AddState(const PoseEstimate<Dim>& odometry,
                                   const TangentMatrix<Dim>& noise) {
  believed_.AddState(odometry, noise);
  if (contender_) contender_->AddState(odometry, noise);
}

template <int Dim>
void PoseHypotheses<Dim>::ChangeFrame(const Pose<Dim>& T_new_old) {
  believed_.ChangeFrame(T_new_old);
  if (contender_) contender_->ChangeFrame(T_new_old);
}

template <int Dim>
EdgeTest PoseHypotheses<Dim>::AddLoop(const LoopEdge<Dim>& loop) {
  EdgeTest test = believed_.AddLoop(loop);
  if (test.valid) {
    contender_.reset();
    believed_.Solve();
    return test;
  }
  Contend(loop);
  if (support_ >= options_.takeover_support) {
    believed_ = *std::exchange(contender_, std::nullopt);
    test.valid = true;
  }
  return test;
}

template <int Dim>
void PoseHypotheses<Dim>::Contend(const LoopEdge<Dim>& loop) {
  if (contender_ && contender_->AddLoop(loop).valid) {
    contender_->Solve();
    ++support_;
    return;
  }
  contender_.emplace(options_);
  contender_->Reset({.pose = loop.pose, .covariance = loop.reused_covariance}, loop.lasting);
  support_ = 1;
}

template class PoseHypotheses<2>;
template class PoseHypotheses<3>;

}  // namespace dcloc
