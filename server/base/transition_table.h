#pragma once

#include <array>
#include <cstddef>

namespace dcloc::server {

/// One arrow of a state machine: in `from`, `event` leads to `to`, and `action` is to be done.
template <typename State, typename Event, typename Action>
struct TransitionArrow {
  State from;
  Event event;
  State to;
  Action action;
};

/// Where `event` leads from `state`, and what is to be done: a `Result` of a state and an action.
/// Without an arrow in the table the state stays as it is, with `Action::kNone`.
template <typename Result, typename State, typename Event, typename Action, std::size_t kCount>
Result NextIn(const std::array<TransitionArrow<State, Event, Action>, kCount>& table, State state,
              Event event) {
  for (const TransitionArrow<State, Event, Action>& arrow : table) {
    if (arrow.from == state && arrow.event == event) return {arrow.to, arrow.action};
  }
  return {state, Action::kNone};
}

}  // namespace dcloc::server
