#pragma once

#include "dcloc/v1/map_service.grpc.pb.h"
#include "server/storage_host.h"

namespace dcloc::server {

/// MapService over a MapStore. All of it may wait for a disk, so all of it runs on the storage
/// pool.
class MapService final : public v1::MapService::CallbackService {
 public:
  explicit MapService(StorageHost host);

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
  grpc::ServerReadReactor<v1::UploadMapRequest>* UploadMap(
      grpc::CallbackServerContext* context, v1::UploadMapResponse* response) override;
  grpc::ServerWriteReactor<v1::DownloadMapResponse>* DownloadMap(
      grpc::CallbackServerContext* context, const v1::DownloadMapRequest* request) override;
  grpc::ServerUnaryReactor* ActivateMapVersion(grpc::CallbackServerContext* context,
                                               const v1::ActivateMapVersionRequest* request,
                                               v1::ActivateMapVersionResponse* response) override;
  grpc::ServerUnaryReactor* DeleteMapVersion(grpc::CallbackServerContext* context,
                                             const v1::DeleteMapVersionRequest* request,
                                             v1::DeleteMapVersionResponse* response) override;
  grpc::ServerUnaryReactor* DeleteMap(grpc::CallbackServerContext* context,
                                      const v1::DeleteMapRequest* request,
                                      v1::DeleteMapResponse* response) override;

 private:
  const StorageHost host_;
};

}  // namespace dcloc::server
