#pragma once

#include <array>
#include <cstddef>

namespace dcloc {

/// One arrow of a state machine: in `from`, `event` leads to `to`.
template <typename State, typename Event>
struct Transition {
  State from;
  Event event;
  State to;
};

/// Where `event` leads from `state`. Without an arrow in the table the state stays as it is.
template <typename State, typename Event, std::size_t kCount>
State Next(const std::array<Transition<State, Event>, kCount>& table, State state, Event event) {
  for (const Transition<State, Event>& arrow : table) {
    if (arrow.from == state && arrow.event == event) return arrow.to;
  }
  return state;
}

}  // namespace dcloc
