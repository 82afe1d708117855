#include "client/evaluation/faults/fault_list.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "client/evaluation/faults/map_faults.h"
#include "client/evaluation/faults/mover_faults.h"
#include "client/evaluation/faults/place_faults.h"
#include "client/evaluation/faults/radar_faults.h"
#include "client/evaluation/faults/target_faults.h"
#include "client/evaluation/faults/time_faults.h"
#include "client/evaluation/faults/velocity_faults.h"

namespace dcloc::faults {
namespace {

constexpr std::string_view kQuickFaults[] = {"velocity-zero-3s", "time-forward-5s",
                                             "place-skipped-20m", "movers-truck-along",
                                             "map-other-ahead"};

bool IsCalled(const Fault& fault, const std::string& name) {
  return fault.id == name || fault.family == name;
}

bool IsCalled(const World& world, const std::string& name) {
  return world.name == name || world.kind == name;
}

// Keeps those that one of the names calls, where one calls any; the names that do are `used`.
template <typename Item>
void KeepCalled(const std::vector<std::string>& names, std::vector<Item>& items,
                std::set<std::string>& used) {
  std::vector<Item> kept;
  for (Item& item : items) {
    bool is_called = false;
    for (const std::string& name : names) {
      if (!IsCalled(item, name)) continue;
      is_called = true;
      used.insert(name);
    }
    if (is_called) kept.push_back(item);
  }
  if (!kept.empty()) items = std::move(kept);
}

std::string NamesIn(const Selection& all) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  };
  for (const World& world : all.worlds) add(world.kind);
  for (const Fault& fault : all.faults) add(fault.family);
  for (const Fault& fault : all.faults) add(fault.id);
  return absl::StrJoin(names, ", ");
}

}  // namespace

std::vector<Fault> AllFaults(bool quick) {
  std::vector<Fault> faults;
  for (const auto& family : {VelocityFaults(), TimeFaults(), RadarFaults(), TargetFaults(),
                             PlaceFaults(), MoverFaults(), MapFaults()}) {
    for (const Fault& fault : family) {
      const bool is_quick = std::ranges::find(kQuickFaults, fault.id) != std::end(kQuickFaults);
      if (!quick || is_quick) faults.push_back(fault);
    }
  }
  return faults;
}

absl::StatusOr<Selection> Select(Selection all, const std::vector<std::string>& names) {
  const std::string known = NamesIn(all);
  std::set<std::string> used;
  KeepCalled(names, all.faults, used);
  KeepCalled(names, all.worlds, used);
  for (const std::string& name : names) {
    if (used.contains(name)) continue;
    return absl::InvalidArgumentError(
        absl::StrFormat("only is '%s'; it must be one of %s", name, known));
  }
  return all;
}

}  // namespace dcloc::faults
