#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/support/server_interceptor.h>

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/base/within_memory.h"

namespace dcloc::server {

/// gRPC 1.51 ends a call whose only request does not parse with UNIMPLEMENTED and no message. This
/// says INVALID_ARGUMENT, and why. Calls that stream requests parse them on their own.
class UnparsedRequests final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    grpc::experimental::Interceptor* interceptor = nullptr;
    WithinMemory([&] {
      if (HasOneRequest(info->method())) interceptor = new Interceptor(info->method());
    }).IgnoreError();
    return interceptor;
  }

 private:
  /// Of "/package.Service/Method"; null if it is none of ours.
  static const google::protobuf::MethodDescriptor* MethodOf(std::string path) {
    std::ranges::replace(path, '/', '.');
    return google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(path.substr(1));
  }

  static bool HasOneRequest(const char* path) {
    const auto* method = MethodOf(path);
    return method != nullptr && !method->client_streaming();
  }

  class Interceptor final : public grpc::experimental::Interceptor {
   public:
    explicit Interceptor(const char* path) : path_(path) {}

    void Intercept(grpc::experimental::InterceptorBatchMethods* batch) override {
      if (batch->QueryInterceptionHookPoint(
              grpc::experimental::InterceptionHookPoints::PRE_SEND_STATUS)) {
        WithinMemory([&] { Correct(batch); }).IgnoreError();
      }
      batch->Proceed();
    }

   private:
    void Correct(grpc::experimental::InterceptorBatchMethods* batch) const {
      const grpc::Status status = batch->GetSendStatus();
      if (status.error_code() != grpc::StatusCode::UNIMPLEMENTED ||
          !status.error_message().empty()) {
        return;
      }
      const auto* method = MethodOf(path_);
      if (method == nullptr) return;
      batch->ModifySendStatus(grpc::Status(
          grpc::StatusCode::INVALID_ARGUMENT,
          absl::StrCat("the message does not parse as ", method->input_type()->full_name())));
    }

    const std::string path_;
  };
};

}  // namespace dcloc::server
