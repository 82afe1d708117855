#include "server/maps/service/map_service.h"

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "server/base/check.h"
#include "server/convert/map.h"
#include "server/convert/page.h"
#include "server/maps/service/build_stream.h"
#include "server/maps/service/download_stream.h"
#include "server/maps/service/map_deletion.h"
#include "server/maps/service/map_labels.h"
#include "server/maps/service/map_places.h"
#include "server/maps/service/upload_stream.h"
#include "server/rpc/refused_stream.h"
#include "server/rpc/unary.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr std::int64_t kMaxVersion = std::numeric_limits<std::int64_t>::max();

absl::Status Check(const std::string& map_name, std::int64_t version, std::int64_t min_version) {
  absl::Status status = CheckMapName("map_name", map_name);
  status.Update(CheckIntegerBetween("version", version, min_version, kMaxVersion));
  return status;
}

absl::Status ListMaps(Catalogue& catalogue, const std::string& tenant,
                      const v1::ListMapsRequest& request, v1::ListMapsResponse* response) {
  const absl::StatusOr<int> size = convert::PageSizeFromProto(request.page_size());
  if (!size.ok()) return size.status();
  if (absl::Status status = convert::CheckPageToken(request.page_token()); !status.ok()) {
    return status;
  }
  if (!request.name_prefix().empty()) {
    absl::Status status = CheckMapName("name_prefix", request.name_prefix());
    if (!status.ok()) return status;
  }
  const std::string after =
      request.page_token().empty() ? "" : ScopedMapName(tenant, request.page_token());
  // One more than a page holds tells whether another one follows.
  const absl::StatusOr<std::vector<MapRecord>> maps =
      catalogue.ListMaps(ScopedMapName(tenant, request.name_prefix()), after, *size + 1);
  if (!maps.ok()) return maps.status();
  for (const MapRecord& record : *maps) {
    if (response->maps_size() == *size) {
      response->set_next_page_token(response->maps(*size - 1).name());
      break;
    }
    convert::ToProto(record, response->add_maps());
  }
  return absl::OkStatus();
}

absl::Status ListVersions(Catalogue& catalogue, const std::string& tenant,
                          const v1::ListMapVersionsRequest& request,
                          v1::ListMapVersionsResponse* response) {
  absl::Status status = CheckMapName("map_name", request.map_name());
  const absl::StatusOr<int> size = convert::PageSizeFromProto(request.page_size());
  const absl::StatusOr<std::int64_t> below =
      convert::NumberFromPageToken(request.page_token(), kMaxVersion);
  status.Update(size.status());
  status.Update(below.status());
  if (!status.ok()) return status;
  const absl::StatusOr<std::vector<MapVersionRecord>> versions =
      catalogue.ListVersions(ScopedMapName(tenant, request.map_name()), *below, *size + 1);
  if (!versions.ok()) return versions.status();
  for (const MapVersionRecord& record : *versions) {
    if (response->versions_size() == *size) {
      response->set_next_page_token(std::to_string(response->versions(*size - 1).version()));
      break;
    }
    convert::ToProto(record, response->add_versions());
  }
  return absl::OkStatus();
}

absl::Status GetMap(Catalogue& catalogue, const std::string& tenant, const std::string& map_name,
                    v1::Map* message) {
  if (absl::Status status = CheckMapName("map_name", map_name); !status.ok()) {
    return status;
  }
  const absl::StatusOr<MapRecord> record = catalogue.GetMap(ScopedMapName(tenant, map_name));
  if (!record.ok()) return record.status();
  convert::ToProto(*record, message);
  return absl::OkStatus();
}

absl::Status GetUpload(MapStore& store, const std::string& tenant, const std::string& sha256,
                       v1::GetMapUploadResponse* response) {
  if (absl::Status status = convert::CheckSha256("sha256", sha256); !status.ok()) return status;
  const absl::StatusOr<bool> stored = store.HasStored(ScopedMapName(tenant, ""), sha256);
  if (!stored.ok()) return stored.status();
  const absl::StatusOr<std::int64_t> size = store.incoming().DurableSize(tenant, sha256);
  if (!size.ok()) return size.status();
  response->set_stored(*stored);
  response->set_durable_size_bytes(*size);
  return absl::OkStatus();
}

absl::Status GetVersion(Catalogue& catalogue, const std::string& tenant,
                        const v1::GetMapVersionRequest& request, v1::MapVersion* message) {
  if (absl::Status status = Check(request.map_name(), request.version(), 0); !status.ok()) {
    return status;
  }
  const absl::StatusOr<MapVersionRecord> record =
      catalogue.GetVersion(ScopedMapName(tenant, request.map_name()), request.version());
  if (!record.ok()) return record.status();
  convert::ToProto(*record, message);
  return absl::OkStatus();
}

absl::Status AnswerBuild(absl::StatusOr<v1::MapBuild> build, v1::MapBuild* message) {
  if (!build.ok()) return build.status();
  *message = *std::move(build);
  return absl::OkStatus();
}

}  // namespace

MapService::MapService(RpcContext host, PassStore& passes, SessionMover move_sessions,
                       SessionDrainer drain_sessions)
    : host_(host),
      passes_(passes),
      move_sessions_(std::move(move_sessions)),
      drain_sessions_(std::move(drain_sessions)),
      builds_(host.store, passes, host.limits) {
  AwaitRequests(host.awaited_requests, &MapService::ListMaps, &MapService::GetMap,
                &MapService::ListMapVersions, &MapService::GetMapVersion, &MapService::GetMapUpload,
                &MapService::DownloadMap, &MapService::ActivateMapVersion, &MapService::RollBackMap,
                &MapService::SetMapCanary, &MapService::FindCoverage, &MapService::ReadMapTile,
                &MapService::GetMapBuild, &MapService::ListMapBuilds, &MapService::CancelMapBuild,
                &MapService::DeleteMapVersion, &MapService::DeleteMap);
}

grpc::ServerUnaryReactor* MapService::ListMaps(grpc::CallbackServerContext* context,
                                               const v1::ListMapsRequest* request,
                                               v1::ListMapsResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return server::ListMaps(host_.store.catalogue(), principal.tenant, *request, response);
  });
}

grpc::ServerUnaryReactor* MapService::GetMap(grpc::CallbackServerContext* context,
                                             const v1::GetMapRequest* request,
                                             v1::GetMapResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return server::GetMap(host_.store.catalogue(), principal.tenant, request->map_name(),
                          response->mutable_map());
  });
}

grpc::ServerUnaryReactor* MapService::ListMapVersions(grpc::CallbackServerContext* context,
                                                      const v1::ListMapVersionsRequest* request,
                                                      v1::ListMapVersionsResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return ListVersions(host_.store.catalogue(), principal.tenant, *request, response);
  });
}

grpc::ServerUnaryReactor* MapService::GetMapVersion(grpc::CallbackServerContext* context,
                                                    const v1::GetMapVersionRequest* request,
                                                    v1::GetMapVersionResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return GetVersion(host_.store.catalogue(), principal.tenant, *request,
                      response->mutable_version());
  });
}

grpc::ServerReadReactor<grpc::ByteBuffer>* MapService::UploadMap(
    grpc::CallbackServerContext* context, grpc::ByteBuffer* response) {
  return BeginWithinMemory<grpc::ServerReadReactor<grpc::ByteBuffer>>(
      [&] { return UploadStream::Start(context, host_, response); });
}

grpc::ServerWriteReactor<v1::DownloadMapResponse>* MapService::DownloadMap(
    grpc::CallbackServerContext* context, const v1::DownloadMapRequest* request) {
  return BeginWithinMemory<grpc::ServerWriteReactor<v1::DownloadMapResponse>>(
      [&] { return DownloadStream::Start(host_, downloads_, context, *request); });
}

grpc::ServerUnaryReactor* MapService::GetMapUpload(grpc::CallbackServerContext* context,
                                                   const v1::GetMapUploadRequest* request,
                                                   v1::GetMapUploadResponse* response) {
  return RunUnary(
      host_, context, request,
      [this, request, response](const Principal& principal) {
        return GetUpload(host_.store, principal.tenant, request->sha256(), response);
      },
      Lane::kLengthy);
}

grpc::ServerUnaryReactor* MapService::ActivateMapVersion(
    grpc::CallbackServerContext* context, const v1::ActivateMapVersionRequest* request,
    v1::ActivateMapVersionResponse* response) {
  return RunUnary(
      host_, context, request,
      [this, request, response](const Principal& principal) {
        return Activate(host_.store, move_sessions_, principal.tenant, *request, response);
      },
      Lane::kLengthy);
}

grpc::ServerUnaryReactor* MapService::RollBackMap(grpc::CallbackServerContext* context,
                                                  const v1::RollBackMapRequest* request,
                                                  v1::RollBackMapResponse* response) {
  return RunUnary(
      host_, context, request,
      [this, request, response](const Principal& principal) {
        return RollBack(host_.store, move_sessions_, principal.tenant, *request, response);
      },
      Lane::kLengthy);
}

grpc::ServerUnaryReactor* MapService::SetMapCanary(grpc::CallbackServerContext* context,
                                                   const v1::SetMapCanaryRequest* request,
                                                   v1::SetMapCanaryResponse* response) {
  return RunUnary(
      host_, context, request,
      [this, request, response](const Principal& principal) {
        return SetCanary(host_.store, principal.tenant, *request, response->mutable_map());
      },
      Lane::kLengthy);
}

grpc::ServerUnaryReactor* MapService::FindCoverage(grpc::CallbackServerContext* context,
                                                   const v1::FindCoverageRequest* request,
                                                   v1::FindCoverageResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return server::FindCoverage(host_.store, principal.tenant, *request, response);
  });
}

grpc::ServerUnaryReactor* MapService::ReadMapTile(grpc::CallbackServerContext* context,
                                                  const v1::ReadMapTileRequest* request,
                                                  v1::ReadMapTileResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return server::ReadMapTile(host_.store, principal.tenant, *request, response);
  });
}

grpc::ServerReadReactor<grpc::ByteBuffer>* MapService::StartMapBuild(
    grpc::CallbackServerContext* context, grpc::ByteBuffer* response) {
  return BeginWithinMemory<grpc::ServerReadReactor<grpc::ByteBuffer>>(
      [&] { return BuildStream::Start(context, host_, builds_, response); });
}

grpc::ServerUnaryReactor* MapService::GetMapBuild(grpc::CallbackServerContext* context,
                                                  const v1::GetMapBuildRequest* request,
                                                  v1::GetMapBuildResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return AnswerBuild(builds_.Get(principal.tenant, request->build_id()),
                       response->mutable_build());
  });
}

grpc::ServerUnaryReactor* MapService::ListMapBuilds(grpc::CallbackServerContext* context,
                                                    const v1::ListMapBuildsRequest* request,
                                                    v1::ListMapBuildsResponse* response) {
  return RunUnary(host_, context, request, [this, response](const Principal& principal) {
    absl::StatusOr<std::vector<v1::MapBuild>> builds = builds_.List(principal.tenant);
    if (!builds.ok()) return builds.status();
    for (v1::MapBuild& build : *builds) *response->add_builds() = std::move(build);
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* MapService::CancelMapBuild(grpc::CallbackServerContext* context,
                                                     const v1::CancelMapBuildRequest* request,
                                                     v1::CancelMapBuildResponse* response) {
  return RunUnary(host_, context, request, [this, request, response](const Principal& principal) {
    return AnswerBuild(builds_.Cancel(principal.tenant, request->build_id()),
                       response->mutable_build());
  });
}

grpc::ServerUnaryReactor* MapService::DeleteMapVersion(grpc::CallbackServerContext* context,
                                                       const v1::DeleteMapVersionRequest* request,
                                                       v1::DeleteMapVersionResponse* /*response*/) {
  return RunUnary(
      host_, context, request,
      [this, request](const Principal& principal) {
        return DeleteVersion(host_.store, drain_sessions_, principal.tenant, *request);
      },
      Lane::kLengthy);
}

grpc::ServerUnaryReactor* MapService::DeleteMap(grpc::CallbackServerContext* context,
                                                const v1::DeleteMapRequest* request,
                                                v1::DeleteMapResponse* /*response*/) {
  return RunUnary(
      host_, context, request,
      [this, request](const Principal& principal) {
        return server::DeleteMap(host_.store, passes_, drain_sessions_, principal.tenant, *request);
      },
      Lane::kLengthy);
}

}  // namespace dcloc::server
