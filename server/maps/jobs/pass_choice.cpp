#include "server/maps/jobs/pass_choice.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"

namespace dcloc::server {
namespace {

constexpr std::size_t kMaxPasses = 100;
constexpr std::size_t kMinWitnesses = 2;  // besides the judge

using Witness = std::pair<std::string, std::int64_t>;

Witness WitnessOf(const PassRow& row) {
  constexpr std::int64_t kDay_ns = 86'400'000'000'000;
  return {row.vehicle, row.first_stamp_ns / kDay_ns};
}

std::size_t WitnessCount(const std::vector<PassRow>& rows) {
  std::set<Witness> witnesses;
  for (const PassRow& row : rows) witnesses.insert(WitnessOf(row));
  return witnesses.size();
}

}  // namespace

absl::StatusOr<PassChoice> ChoosePasses(const std::vector<PassRow>& rows, SystemTime since,
                                        std::int64_t max_bytes) {
  std::vector<PassRow> newest;
  std::int64_t size_bytes = 0;
  for (const PassRow& row : rows) {
    size_bytes += row.size_bytes;
    if (row.create_time < since || size_bytes > max_bytes || newest.size() == kMaxPasses) break;
    newest.push_back(row);
  }
  const std::size_t witness_count = WitnessCount(newest);
  if (witness_count < kMinWitnesses + 1) {
    return absl::FailedPreconditionError(
        absl::StrFormat("an update needs passes of %d vehicles or days; since the version was made "
                        "%d passes of %d were kept",
                        kMinWitnesses + 1, newest.size(), witness_count));
  }
  const PassRow judge = *std::ranges::max_element(newest, {}, &PassRow::scan_count);
  std::erase_if(newest, [&](const PassRow& row) { return WitnessOf(row) == WitnessOf(judge); });
  newest.push_back(judge);
  const std::size_t held_out = newest.size() - 1;
  return PassChoice{.passes = std::move(newest), .held_out = held_out};
}

}  // namespace dcloc::server
