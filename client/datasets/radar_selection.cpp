#include "client/datasets/radar_selection.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace dcloc {

absl::Status CheckRadars(const std::vector<std::string>& wanted,
                         const std::vector<std::string>& available) {
  for (auto id = wanted.begin(); id != wanted.end(); ++id) {
    if (std::find(available.begin(), available.end(), *id) == available.end()) {
      return absl::NotFoundError(absl::StrCat(
          "the drive has no radar \"", *id, "\"; its radars are ", absl::StrJoin(available, ", ")));
    }
    if (std::find(wanted.begin(), id, *id) != id) {
      return absl::InvalidArgumentError(absl::StrCat("radar \"", *id, "\" is named twice"));
    }
  }
  return absl::OkStatus();
}

bool IsWanted(const std::vector<std::string>& wanted, absl::string_view id) {
  return wanted.empty() || std::find(wanted.begin(), wanted.end(), id) != wanted.end();
}

}  // namespace dcloc
