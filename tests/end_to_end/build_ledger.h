#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "client/sdk/map_client.h"

namespace dcloc {

/// The builds of one map that servers have acknowledged, and what must come of each: a version, or
/// the word that too many servers died over it.
class BuildLedger {
 public:
  explicit BuildLedger(std::string map_name) : map_name_(std::move(map_name)) {}

  /// Has builds made, one after the other, until the server is gone. An answer that must not be is
  /// an error.
  absl::Status Work(client::MapClient maps);

  /// Takes in what has ended. Errors say which build is not known any more.
  absl::Status Check(client::MapClient& maps);

  /// Waits until all have ended, and looks for their versions.
  absl::Status Finish(client::MapClient& maps, std::chrono::seconds bound);

  /// Hashes of the files that the map's versions have, once finished.
  const std::set<std::string>& Files() const { return files_; }

  int acknowledged_count() const { return acknowledged_count_; }
  int given_up_count() const { return given_up_count_; }

 private:
  absl::Status Step(client::MapClient& maps);
  absl::Status TakeEnd(const v1::MapBuild& build);

  const std::string map_name_;
  int build_count_ = 0;
  int acknowledged_count_ = 0;
  int given_up_count_ = 0;
  std::set<std::string> running_;                 ///< by id
  std::map<std::int64_t, std::string> versions_;  ///< hashes of what builds said that they made
  std::set<std::string> files_;
};

}  // namespace dcloc
