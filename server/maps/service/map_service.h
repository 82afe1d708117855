#pragma once

#include "dcloc/v1/map_service.grpc.pb.h"
#include "server/maps/jobs/map_builds.h"
#include "server/maps/service/download_slots.h"
#include "server/maps/service/map_deletion.h"
#include "server/maps/service/map_labels.h"
#include "server/net/awaiting_service.h"
#include "server/passes/pass_store.h"
#include "server/rpc/rpc_context.h"

namespace dcloc::server {

/// Streamed requests come as bytes, see `ReadStream`.
using RawStreamsMapService = v1::MapService::WithRawCallbackMethod_UploadMap<
    v1::MapService::WithRawCallbackMethod_StartMapBuild<v1::MapService::CallbackService>>;

/// MapService over a MapStore. All calls may wait for a disk, so all run on the storage pool.
class MapService final : public AwaitingService<RawStreamsMapService> {
 public:
  /// The consent of a map that is deleted goes from `passes`, which outlives its calls.
  MapService(RpcContext host, PassStore& passes, SessionMover move_sessions,
             SessionDrainer drain_sessions);

  grpc::ServerUnaryReactor* ListMaps(grpc::CallbackServerContext* context,
                                     const v1::ListMapsRequest* request,
                                     v1::ListMapsResponse* response) override;
  grpc::ServerUnaryReactor* GetMap(grpc::CallbackServerContext* context,
                                   const v1::GetMapRequest* request,
                                   v1::GetMapResponse* response) override;
  grpc::ServerUnaryReactor* ListMapVersions(grpc::CallbackServerContext* context,
                                            const v1::ListMapVersionsRequest* request,
                                            v1::ListMapVersionsResponse* response) override;
  grpc::ServerUnaryReactor* GetMapVersion(grpc::CallbackServerContext* context,
                                          const v1::GetMapVersionRequest* request,
                                          v1::GetMapVersionResponse* response) override;
  grpc::ServerReadReactor<grpc::ByteBuffer>* UploadMap(grpc::CallbackServerContext* context,
                                                       grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<v1::DownloadMapResponse>* DownloadMap(
      grpc::CallbackServerContext* context, const v1::DownloadMapRequest* request) override;
  grpc::ServerUnaryReactor* ActivateMapVersion(grpc::CallbackServerContext* context,
                                               const v1::ActivateMapVersionRequest* request,
                                               v1::ActivateMapVersionResponse* response) override;
  grpc::ServerUnaryReactor* GetMapUpload(grpc::CallbackServerContext* context,
                                         const v1::GetMapUploadRequest* request,
                                         v1::GetMapUploadResponse* response) override;
  grpc::ServerUnaryReactor* RollBackMap(grpc::CallbackServerContext* context,
                                        const v1::RollBackMapRequest* request,
                                        v1::RollBackMapResponse* response) override;
  grpc::ServerUnaryReactor* SetMapCanary(grpc::CallbackServerContext* context,
                                         const v1::SetMapCanaryRequest* request,
                                         v1::SetMapCanaryResponse* response) override;
  grpc::ServerUnaryReactor* FindCoverage(grpc::CallbackServerContext* context,
                                         const v1::FindCoverageRequest* request,
                                         v1::FindCoverageResponse* response) override;
  grpc::ServerUnaryReactor* ReadMapTile(grpc::CallbackServerContext* context,
                                        const v1::ReadMapTileRequest* request,
                                        v1::ReadMapTileResponse* response) override;
  grpc::ServerReadReactor<grpc::ByteBuffer>* StartMapBuild(grpc::CallbackServerContext* context,
                                                           grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetMapBuild(grpc::CallbackServerContext* context,
                                        const v1::GetMapBuildRequest* request,
                                        v1::GetMapBuildResponse* response) override;
  grpc::ServerUnaryReactor* ListMapBuilds(grpc::CallbackServerContext* context,
                                          const v1::ListMapBuildsRequest* request,
                                          v1::ListMapBuildsResponse* response) override;
  grpc::ServerUnaryReactor* CancelMapBuild(grpc::CallbackServerContext* context,
                                           const v1::CancelMapBuildRequest* request,
                                           v1::CancelMapBuildResponse* response) override;
  grpc::ServerUnaryReactor* DeleteMapVersion(grpc::CallbackServerContext* context,
                                             const v1::DeleteMapVersionRequest* request,
                                             v1::DeleteMapVersionResponse* response) override;
  grpc::ServerUnaryReactor* DeleteMap(grpc::CallbackServerContext* context,
                                      const v1::DeleteMapRequest* request,
                                      v1::DeleteMapResponse* response) override;

  /// Downloads that are under way.
  int download_count() const { return downloads_.count(); }

 private:
  const RpcContext host_;
  PassStore& passes_;
  const SessionMover move_sessions_;
  const SessionDrainer drain_sessions_;
  DownloadSlots downloads_;
  MapBuilds builds_;
};

}  // namespace dcloc::server
