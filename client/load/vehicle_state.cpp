#include "client/load/vehicle_state.h"

#include <array>

#include "core/localizer/transition.h"

namespace dcloc::load {
namespace {

using RunArrow = Transition<VehicleState, VehicleEvent>;
using StreamArrow = Transition<StreamState, StreamEvent>;

constexpr std::array kRunArrows = {
    RunArrow{VehicleState::kDriving, VehicleEvent::kFinish, VehicleState::kFinishing},
    RunArrow{VehicleState::kDriving, VehicleEvent::kCancel, VehicleState::kCancelled},
    RunArrow{VehicleState::kFinishing, VehicleEvent::kCancel, VehicleState::kCancelled},
    RunArrow{VehicleState::kFinishing, VehicleEvent::kEnd, VehicleState::kDone},
    RunArrow{VehicleState::kCancelled, VehicleEvent::kEnd, VehicleState::kDone},
};

constexpr std::array kStreamArrows = {
    StreamArrow{StreamState::kOpening, StreamEvent::kOpened, StreamState::kOpen},
    StreamArrow{StreamState::kReopening, StreamEvent::kOpened, StreamState::kOpen},
    StreamArrow{StreamState::kOpen, StreamEvent::kCut, StreamState::kCut},
    StreamArrow{StreamState::kOpen, StreamEvent::kClose, StreamState::kClosing},
    StreamArrow{StreamState::kOpen, StreamEvent::kBegin, StreamState::kOpening},
    StreamArrow{StreamState::kClosing, StreamEvent::kBegin, StreamState::kOpening},
    StreamArrow{StreamState::kCut, StreamEvent::kBegin, StreamState::kReopening},
};

}  // namespace

VehicleState Next(VehicleState state, VehicleEvent event) { return Next(kRunArrows, state, event); }

StreamState Next(StreamState state, StreamEvent event) { return Next(kStreamArrows, state, event); }

bool WasOpened(StreamState state) {
  return state == StreamState::kOpen || state == StreamState::kCut ||
         state == StreamState::kClosing;
}

bool FollowsCut(StreamState state) {
  return state == StreamState::kCut || state == StreamState::kReopening;
}

}  // namespace dcloc::load
