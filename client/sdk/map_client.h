#pragma once

#include <grpcpp/channel.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/sdk/map_upload.h"
#include "dcloc/v1/map_service.grpc.pb.h"

namespace dcloc::client {

/// Manages the maps of a server. Calls block, each for `timeout` at most; errors are the server's
/// own, or Unavailable and DeadlineExceeded when it cannot be reached. Thread-safe.
class MapClient {
 public:
  explicit MapClient(const std::shared_ptr<grpc::Channel>& channel,
                     std::chrono::milliseconds timeout = std::chrono::seconds(15));

  /// Adds the map file as a new version, and the map if it is new. If the connection breaks, the
  /// upload continues from the bytes that the server has; only the first call must succeed at once.
  /// On top of `timeout` each call may take as long as the file does at 1 MB/s.
  absl::StatusOr<v1::MapVersion> Upload(const std::filesystem::path& file,
                                        const std::string& map_name, const UploadOptions& options);

  /// Writes a version's file, `version` 0 for the active one: first beside `file`, then renamed
  /// once its hash is verified. DataLoss if the hash is wrong. Has no time limit.
  absl::StatusOr<v1::MapVersion> Download(const std::string& map_name, std::int64_t version,
                                          const std::filesystem::path& file,
                                          const TransferProgress& progress = {});

  /// All maps, by name.
  absl::StatusOr<std::vector<v1::Map>> List();

  /// All versions of a map, newest first.
  absl::StatusOr<std::vector<v1::MapVersion>> ListVersions(const std::string& map_name);

  absl::StatusOr<v1::Map> Get(const std::string& map_name);

  /// `version` 0 is the active one.
  absl::StatusOr<v1::MapVersion> GetVersion(const std::string& map_name, std::int64_t version);

  /// New sessions get this version; running ones too if they are to be moved.
  absl::StatusOr<v1::ActivateMapVersionResponse> Activate(
      const v1::ActivateMapVersionRequest& request);
  absl::StatusOr<v1::Map> Activate(const std::string& map_name, std::int64_t version);

  /// Activates the version that was active before.
  absl::StatusOr<v1::RollBackMapResponse> RollBack(const v1::RollBackMapRequest& request);
  absl::StatusOr<v1::Map> RollBack(const std::string& map_name);

  /// Makes a version the canary for a share of the vehicles, (0, 1]; version 0 and share 0: no
  /// canary.
  absl::StatusOr<v1::Map> SetCanary(const std::string& map_name, std::int64_t version,
                                    double share);

  /// The active versions that cover a place, the nearest first.
  absl::StatusOr<std::vector<v1::MapCoverage>> FindCoverage(const v1::FindCoverageRequest& request);

  /// The landmarks and keyframes in a rectangle.
  absl::StatusOr<v1::ReadMapTileResponse> ReadTile(const v1::ReadMapTileRequest& request);

  /// Has the server make a version of scans at known poses: `next` provides one after the other,
  /// until it returns false. Returns when the server has all scans; the build goes on by itself.
  absl::StatusOr<v1::MapBuild> StartBuild(const v1::MapBuildHeader& header,
                                          const std::function<bool(v1::PosedScan*)>& next);
  /// The same without poses, of one or many drives: `next` provides, for each drive, a message with
  /// `drive` and then one with each of its scans. If it fails, nothing is built.
  using NextMessage = std::function<absl::StatusOr<bool>(v1::StartMapBuildRequest*)>;
  absl::StatusOr<v1::MapBuild> StartSurvey(const v1::MapBuildHeader& header,
                                           const NextMessage& next);
  /// Brings a version up to date with the passes that the server keeps: `header` names the map, and
  /// may name the version.
  absl::StatusOr<v1::MapBuild> StartUpdate(const v1::MapBuildHeader& header);
  absl::StatusOr<v1::MapBuild> GetBuild(const std::string& build_id);
  absl::StatusOr<v1::MapBuild> CancelBuild(const std::string& build_id);

  /// Those under way and the last ones that have ended, newest first.
  absl::StatusOr<std::vector<v1::MapBuild>> ListBuilds();

  /// FailedPrecondition while sessions or downloads use it. `drain`: its sessions move to another
  /// version, or are ended where they cannot.
  absl::Status DeleteVersion(const std::string& map_name, std::int64_t version, bool drain = false);

  /// Deletes the map with all of its versions. `drain`: its sessions are ended.
  absl::Status Delete(const std::string& map_name, bool drain = false);

 private:
  absl::StatusOr<v1::MapBuild> SendBuild(const v1::MapBuildHeader& header, const NextMessage& next);

  std::unique_ptr<v1::MapService::Stub> stub_;
  std::chrono::milliseconds timeout_;
};

}  // namespace dcloc::client
