#include "client/sdk/map_client.h"

#include <grpcpp/client_context.h>

#include <utility>

#include "client/sdk/calls.h"
#include "client/sdk/map_download.h"
#include "client/sdk/status.h"

namespace dcloc::client {
namespace {

using Milliseconds = std::chrono::milliseconds;

}  // namespace

MapClient::MapClient(const std::shared_ptr<grpc::Channel>& channel, Milliseconds timeout)
    : stub_(v1::MapService::NewStub(channel)), timeout_(timeout) {}

absl::StatusOr<v1::MapVersion> MapClient::Upload(const std::filesystem::path& file,
                                                 const std::string& map_name,
                                                 const UploadOptions& options) {
  return UploadMapFile(*stub_, file, map_name, options, timeout_);
}

absl::StatusOr<v1::MapVersion> MapClient::Download(const std::string& map_name,
                                                   std::int64_t version,
                                                   const std::filesystem::path& file,
                                                   const TransferProgress& progress) {
  v1::DownloadMapRequest request;
  request.set_map_name(map_name);
  request.set_version(version);
  return DownloadMapFile(*stub_, request, file, progress);
}

absl::StatusOr<std::vector<v1::Map>> MapClient::List() {
  return CallForAllPages<v1::Map>(*stub_, &v1::MapService::Stub::ListMaps, v1::ListMapsRequest(),
                                  &v1::ListMapsResponse::mutable_maps, timeout_);
}

absl::StatusOr<std::vector<v1::MapVersion>> MapClient::ListVersions(const std::string& map_name) {
  v1::ListMapVersionsRequest request;
  request.set_map_name(map_name);
  return CallForAllPages<v1::MapVersion>(*stub_, &v1::MapService::Stub::ListMapVersions, request,
                                         &v1::ListMapVersionsResponse::mutable_versions, timeout_);
}

absl::StatusOr<v1::Map> MapClient::Get(const std::string& map_name) {
  v1::GetMapRequest request;
  request.set_map_name(map_name);
  auto response = Call(*stub_, &v1::MapService::Stub::GetMap, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_map());
}

absl::StatusOr<v1::MapVersion> MapClient::GetVersion(const std::string& map_name,
                                                     std::int64_t version) {
  v1::GetMapVersionRequest request;
  request.set_map_name(map_name);
  request.set_version(version);
  auto response = Call(*stub_, &v1::MapService::Stub::GetMapVersion, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_version());
}

absl::StatusOr<v1::ActivateMapVersionResponse> MapClient::Activate(
    const v1::ActivateMapVersionRequest& request) {
  return Call(*stub_, &v1::MapService::Stub::ActivateMapVersion, request, timeout_);
}

absl::StatusOr<v1::Map> MapClient::Activate(const std::string& map_name, std::int64_t version) {
  v1::ActivateMapVersionRequest request;
  request.set_map_name(map_name);
  request.set_version(version);
  auto response = Activate(request);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_map());
}

absl::StatusOr<v1::RollBackMapResponse> MapClient::RollBack(const v1::RollBackMapRequest& request) {
  return Call(*stub_, &v1::MapService::Stub::RollBackMap, request, timeout_);
}

absl::StatusOr<v1::Map> MapClient::RollBack(const std::string& map_name) {
  v1::RollBackMapRequest request;
  request.set_map_name(map_name);
  auto response = RollBack(request);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_map());
}

absl::StatusOr<v1::Map> MapClient::SetCanary(const std::string& map_name, std::int64_t version,
                                             double share) {
  v1::SetMapCanaryRequest request;
  request.set_map_name(map_name);
  request.set_version(version);
  request.set_share(share);
  auto response = Call(*stub_, &v1::MapService::Stub::SetMapCanary, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_map());
}

absl::StatusOr<std::vector<v1::MapCoverage>> MapClient::FindCoverage(
    const v1::FindCoverageRequest& request) {
  auto response = Call(*stub_, &v1::MapService::Stub::FindCoverage, request, timeout_);
  if (!response.ok()) return response.status();
  return std::vector<v1::MapCoverage>(response->coverages().begin(), response->coverages().end());
}

absl::StatusOr<v1::ReadMapTileResponse> MapClient::ReadTile(const v1::ReadMapTileRequest& request) {
  return Call(*stub_, &v1::MapService::Stub::ReadMapTile, request, timeout_);
}

absl::StatusOr<v1::MapBuild> MapClient::StartBuild(
    const v1::MapBuildHeader& header, const std::function<bool(v1::PosedScan*)>& next) {
  return SendBuild(
      header, [&](v1::StartMapBuildRequest* request) { return next(request->mutable_scan()); });
}

absl::StatusOr<v1::MapBuild> MapClient::StartSurvey(const v1::MapBuildHeader& header,
                                                    const NextMessage& next) {
  v1::MapBuildHeader survey = header;
  survey.set_method(v1::MAP_BUILD_METHOD_SURVEY);
  return SendBuild(survey, next);
}

absl::StatusOr<v1::MapBuild> MapClient::StartUpdate(const v1::MapBuildHeader& header) {
  v1::MapBuildHeader update = header;
  update.set_method(v1::MAP_BUILD_METHOD_UPDATE);
  return SendBuild(update, [](v1::StartMapBuildRequest* /*message*/) { return false; });
}

absl::StatusOr<v1::MapBuild> MapClient::SendBuild(const v1::MapBuildHeader& header,
                                                  const NextMessage& next) {
  // No deadline: how long it takes depends on the drive, and keepalive notices a dead connection.
  grpc::ClientContext context;
  v1::StartMapBuildResponse response;
  const auto writer = stub_->StartMapBuild(&context, &response);
  v1::StartMapBuildRequest request;
  *request.mutable_header() = header;
  bool open = writer->Write(request);
  absl::StatusOr<bool> there = true;
  while (open && (there = next(&request)).ok() && *there) open = writer->Write(request);
  if (!there.ok()) context.TryCancel();  // before the server takes it for the whole
  if (open) writer->WritesDone();
  const grpc::Status status = writer->Finish();
  if (!there.ok()) return there.status();
  if (!status.ok()) return FromGrpc(status);
  return std::move(*response.mutable_build());
}

absl::StatusOr<v1::MapBuild> MapClient::GetBuild(const std::string& build_id) {
  v1::GetMapBuildRequest request;
  request.set_build_id(build_id);
  auto response = Call(*stub_, &v1::MapService::Stub::GetMapBuild, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_build());
}

absl::StatusOr<v1::MapBuild> MapClient::CancelBuild(const std::string& build_id) {
  v1::CancelMapBuildRequest request;
  request.set_build_id(build_id);
  auto response = Call(*stub_, &v1::MapService::Stub::CancelMapBuild, request, timeout_);
  if (!response.ok()) return response.status();
  return std::move(*response->mutable_build());
}

absl::StatusOr<std::vector<v1::MapBuild>> MapClient::ListBuilds() {
  auto response =
      Call(*stub_, &v1::MapService::Stub::ListMapBuilds, v1::ListMapBuildsRequest(), timeout_);
  if (!response.ok()) return response.status();
  return std::vector<v1::MapBuild>(response->builds().begin(), response->builds().end());
}

absl::Status MapClient::DeleteVersion(const std::string& map_name, std::int64_t version,
                                      bool drain) {
  v1::DeleteMapVersionRequest request;
  request.set_map_name(map_name);
  request.set_version(version);
  request.set_drain_sessions(drain);
  return Call(*stub_, &v1::MapService::Stub::DeleteMapVersion, request, timeout_).status();
}

absl::Status MapClient::Delete(const std::string& map_name, bool drain) {
  v1::DeleteMapRequest request;
  request.set_map_name(map_name);
  request.set_drain_sessions(drain);
  return Call(*stub_, &v1::MapService::Stub::DeleteMap, request, timeout_).status();
}

}  // namespace dcloc::client
