#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "client/sdk/map_client.h"

namespace dcloc {

/// One map of a server, all that was ever asked of it and what was acknowledged. Asks for one thing
/// at a time, so that after a crash at most the last one is in doubt.
class MapLedger {
 public:
  /// Whether a server that died may still hold versions, which then cannot be deleted yet.
  enum class Servers { kOne, kSeveral };

  MapLedger(std::string map_name, std::string folder, unsigned seed,
            Servers servers = Servers::kOne)
      : map_name_(std::move(map_name)),
        folder_(std::move(folder)),
        servers_(servers),
        random_(seed) {}

  /// Asks for random things until the server is gone. An answer that must not be is an error.
  absl::Status Work(client::MapClient maps);

  /// Compares with what a server says after a restart, takes over what was in doubt, and finishes
  /// the upload that was cut off. Errors say what was lost or came from nowhere.
  absl::Status Check(client::MapClient& maps);

  /// Hashes of the files that the map's versions have.
  std::set<std::string> Files() const;

  /// What was asked for.
  struct Counts {
    int acknowledged = 0;
    int doubtful = 0;  ///< cut off
    int finished = 0;  ///< uploads that were cut off, and made again
  };
  static Counts Sum(const std::vector<std::unique_ptr<MapLedger>>& ledgers);

 private:
  struct File {
    std::string path;
    std::string sha256;
  };
  using Versions = std::map<std::int64_t, std::string>;  ///< hash of each

  /// What was asked for and not answered yet.
  struct Doubt {
    std::string uploaded_sha256;
    bool activates = false;
    std::int64_t activated = 0;
    std::int64_t deleted = 0;
  };

  absl::Status Step(client::MapClient& maps);
  absl::Status Upload(client::MapClient& maps, const File& file, bool activate,
                      std::chrono::milliseconds give_up_after = {});
  absl::Status Activate(client::MapClient& maps);
  absl::Status RollBack(client::MapClient& maps);
  absl::Status Delete(client::MapClient& maps);
  absl::Status TakeOver(client::MapClient& maps);
  absl::Status FinishUpload(client::MapClient& maps);
  absl::Status CheckVersions(const Versions& there) const;
  absl::Status CheckActive(std::int64_t version, const Versions& there) const;

  absl::StatusOr<File> MakeFile();
  std::int64_t AnyVersion();
  void BecomesActive(std::int64_t version);
  bool Chance(double probability) { return std::bernoulli_distribution(probability)(random_); }

  const std::string map_name_;
  const std::string folder_;
  const Servers servers_;
  std::mt19937 random_;
  int file_count_ = 0;
  File last_file_;

  Versions versions_;
  std::int64_t active_ = 0;
  std::int64_t previous_ = 0;
  Doubt doubt_;

  Counts counts_;
};

}  // namespace dcloc
