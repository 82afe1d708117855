#pragma once

#include "dcloc/v1/pass_service.grpc.pb.h"
#include "server/net/awaiting_service.h"
#include "server/passes/pass_store.h"
#include "server/rpc/rpc_context.h"

namespace dcloc::server {

/// PassService over a PassStore. All calls may wait for storage, so all run on the storage pool.
class PassService final : public AwaitingService<v1::PassService::CallbackService> {
 public:
  /// `passes` outlives its calls.
  PassService(RpcContext host, PassStore& passes);

  grpc::ServerUnaryReactor* SetPassConsent(grpc::CallbackServerContext* context,
                                           const v1::SetPassConsentRequest* request,
                                           v1::SetPassConsentResponse* response) override;
  grpc::ServerUnaryReactor* ListPassConsents(grpc::CallbackServerContext* context,
                                             const v1::ListPassConsentsRequest* request,
                                             v1::ListPassConsentsResponse* response) override;
  grpc::ServerUnaryReactor* ListPasses(grpc::CallbackServerContext* context,
                                       const v1::ListPassesRequest* request,
                                       v1::ListPassesResponse* response) override;

 private:
  const RpcContext host_;
  PassStore& passes_;
};

}  // namespace dcloc::server
