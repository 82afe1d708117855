#include "client/evaluation/faults/rows.h"

#include <algorithm>
#include <map>
#include <utility>

namespace dcloc::faults {
namespace {

/// Results by fault and world.
class ResultTable {
 public:
  explicit ResultTable(std::span<const CaseResult> results) {
    for (const CaseResult& result : results) by_fault_[result.fault].push_back(&result);
  }

  FaultRows RowsFor(const Fault& fault) const {
    FaultRows rows{.id = fault.id, .family = fault.family, .all = {.name = fault.label}};
    const auto found = by_fault_.find(fault.id);
    if (found == by_fault_.end()) return rows;
    const char* const base = fault.is_reversing ? kUndisturbedReversing : kUndisturbed;
    for (const CaseResult* result : found->second) {
      AddCase(*result, base, rows.all);
      if (rows.by_kind.empty() || rows.by_kind.back().name != result->kind) {
        rows.by_kind.push_back({.name = result->kind});
      }
      AddCase(*result, base, rows.by_kind.back());
    }
    return rows;
  }

 private:
  void AddCase(const CaseResult& result, const char* base, FaultRow& row) const {
    Merge(result.record, row.record);
    const auto found = by_fault_.find(base);
    if (found == by_fault_.end()) return;
    const auto beside = std::ranges::find(found->second, result.world, &CaseResult::world);
    if (beside != found->second.end()) Merge((*beside)->record, row.undisturbed);
  }

  std::map<std::string, std::vector<const CaseResult*>> by_fault_;
};

}  // namespace

std::vector<FaultRows> RowsOf(std::span<const CaseResult> results,
                              const std::vector<Fault>& faults) {
  const ResultTable table(results);
  std::vector<FaultRows> all;
  const auto add = [&](const Fault& fault) {
    FaultRows rows = table.RowsFor(fault);
    if (rows.all.record.cases > 0) all.push_back(std::move(rows));
  };
  add({.id = kUndisturbed, .family = kUndisturbed, .label = kUndisturbed});
  add({.id = kUndisturbedReversing,
       .family = kUndisturbed,
       .label = "undisturbed, reversing",
       .is_reversing = true});
  for (const Fault& fault : faults) add(fault);
  return all;
}

}  // namespace dcloc::faults
