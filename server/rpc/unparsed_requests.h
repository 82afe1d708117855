#pragma once

#include <google/protobuf/descriptor.h>
#include <grpcpp/support/server_interceptor.h>

#include <algorithm>
#include <string>

#include "absl/strings/str_cat.h"

namespace dcloc::server {

/// gRPC 1.51 ends a call whose only request does not parse with UNIMPLEMENTED and no message. This
/// says INVALID_ARGUMENT, and why. Calls that stream requests parse them on their own.
class UnparsedRequests final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    using Info = grpc::experimental::ServerRpcInfo;
    const bool has_one_request =
        info->type() == Info::Type::UNARY || info->type() == Info::Type::SERVER_STREAMING;
    return has_one_request ? new Interceptor(info->method()) : nullptr;
  }

 private:
  class Interceptor final : public grpc::experimental::Interceptor {
   public:
    explicit Interceptor(const char* path) : path_(path) {}

    void Intercept(grpc::experimental::InterceptorBatchMethods* batch) override {
      if (batch->QueryInterceptionHookPoint(
              grpc::experimental::InterceptionHookPoints::PRE_SEND_STATUS)) {
        Correct(batch);
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
      // "/package.Service/Method"; one that is really not implemented is not found.
      std::string name = path_.substr(1);
      std::ranges::replace(name, '/', '.');
      const auto* method =
          google::protobuf::DescriptorPool::generated_pool()->FindMethodByName(name);
      if (method == nullptr) return;
      batch->ModifySendStatus(grpc::Status(
          grpc::StatusCode::INVALID_ARGUMENT,
          absl::StrCat("the message does not parse as ", method->input_type()->full_name())));
    }

    const std::string path_;
  };
};

}  // namespace dcloc::server
