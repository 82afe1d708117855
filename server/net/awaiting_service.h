#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/impl/service_type.h>
#include <grpcpp/support/server_callback.h>

#include <memory>
#include <utility>

#include "server/net/awaited_requests.h"

namespace dcloc::server {

/// A generated callback service whose calls of a single request are bounded while that does not
/// come.
template <typename Service>
class AwaitingService : public Service {
 protected:
  /// `methods` are those members of the derived service that take a single request. `requests`
  /// outlives the service.
  template <typename... Methods>
  void AwaitRequests(AwaitedRequests& requests, Methods... methods) {
    (Await(requests, methods), ...);
  }

 private:
  template <typename Derived, typename Request, typename Response>
  using Unary = grpc::ServerUnaryReactor* (Derived::*)(grpc::CallbackServerContext*, const Request*,
                                                       Response*);
  template <typename Derived, typename Request, typename Response>
  using ServerStreaming = grpc::ServerWriteReactor<Response>* (
      Derived::*)(grpc::CallbackServerContext*, const Request*);

  template <typename Derived, typename Request, typename Response>
  void Await(AwaitedRequests& requests, Unary<Derived, Request, Response> method) {
    Replace<Request>(
        requests, std::make_unique<grpc::internal::CallbackUnaryHandler<Request, Response>>(
                      [this, method](grpc::CallbackServerContext* context, const Request* request,
                                     Response* response) {
                        return (static_cast<Derived*>(this)->*method)(context, request, response);
                      }));
  }

  template <typename Derived, typename Request, typename Response>
  void Await(AwaitedRequests& requests, ServerStreaming<Derived, Request, Response> method) {
    Replace<Request>(
        requests,
        std::make_unique<grpc::internal::CallbackServerStreamingHandler<Request, Response>>(
            [this, method](grpc::CallbackServerContext* context, const Request* request) {
              return (static_cast<Derived*>(this)->*method)(context, request);
            }));
  }

  template <typename Request>
  void Replace(AwaitedRequests& requests, std::unique_ptr<grpc::internal::MethodHandler> handler) {
    const int index = MethodThatTakes(Request::descriptor());
    // As a streaming method gRPC tells of it before its request is there.
    this->MarkMethodStreamed(index, requests.Awaiting(std::move(handler)).release());
  }

  /// The place of a method in its service. A request is one method's alone, and in its file.
  static int MethodThatTakes(const google::protobuf::Descriptor* request) {
    const google::protobuf::ServiceDescriptor* service = request->file()->service(0);
    for (int i = 0; i < service->method_count(); ++i) {
      if (service->method(i)->input_type() == request) return i;
    }
    return -1;
  }
};

}  // namespace dcloc::server
