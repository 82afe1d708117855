#include <gmock/gmock.h>
#include <google/protobuf/descriptor.h>
#include <grpcpp/completion_queue.h>
#include <grpcpp/generic/generic_stub.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "dcloc/v1/pass_service.pb.h"
#include "server/app/storage.h"
#include "server/identity/role.h"
#include "spdlog/spdlog.h"
#include "tests/server/fixtures/test_server.h"

// Who may call what: each method of the contract, by each role, in the default tenant and in
// another one, against the server as it is.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

/// For admins of the default tenant alone.
bool IsForAdmins(const std::string& method) {
  return method == "Drain" || method == "ListIdentities" || method == "RevokeIdentity";
}

/// The lowest role that may call a method; what only reads is for viewers.
Role LowestRole(const std::string& method) {
  if (IsForAdmins(method)) return Role::kAdmin;
  constexpr std::array kReading = {"Get", "List", "Read", "Find", "Download", "Watch"};
  const bool reads = std::ranges::any_of(
      kReading, [&](const char* verb) { return absl::StartsWith(method, verb); });
  return reads && method != "GetMapUpload" ? Role::kViewer : Role::kOperator;
}

bool MayCall(const Principal& caller, const std::string& method) {
  const bool is_of_the_whole_server =
      method == "GetServerState" || method == "ListReplicas" || IsForAdmins(method);
  if (is_of_the_whole_server && !caller.tenant.empty()) return false;
  if (caller.role == Role::kVehicle) return method == "Localize" || method == "FindCoverage";
  return caller.role >= LowestRole(method);
}

/// A method's first message: nothing in it but what the server needs to know what is asked for.
std::string RequestOf(const std::string& method, const Principal& caller) {
  v1::LocalizeRequest localize;
  localize.mutable_open()->set_vehicle_id(caller.name);
  v1::UploadMapRequest upload;
  upload.mutable_header();
  v1::StartMapBuildRequest build;
  build.mutable_header();
  if (method == "Localize") return localize.SerializeAsString();
  if (method == "UploadMap") return upload.SerializeAsString();
  return method == "StartMapBuild" ? build.SerializeAsString() : "";
}

class MethodAccessTest : public ::testing::Test {
 protected:
  MethodAccessTest() : identities_(*OpenIdentities(server_.folder.path() / "store")) {
    Token({.name = "first"});
    spdlog::set_level(spdlog::level::err);  // denials are many here
  }

  std::string Token(const Principal& principal) const {
    return *identities_->Create(Proof::kToken, principal, {});
  }

  /// Sends one message, says that no more come, and gives the status.
  grpc::Status Ask(const google::protobuf::MethodDescriptor& method, const std::string& token,
                   const Principal& caller) const {
    grpc::CompletionQueue queue;
    const auto wait = [&queue] {
      void* tag = nullptr;
      bool ok = false;
      return queue.Next(&tag, &ok) && ok;
    };
    CallAs call(token);
    const auto stream =
        grpc::GenericStub(server_.channel)
            .PrepareCall(&call,
                         absl::StrCat("/", method.service()->full_name(), "/", method.name()),
                         &queue);
    stream->StartCall(nullptr);
    wait();
    const grpc::Slice bytes(RequestOf(method.name(), caller));
    stream->WriteLast(grpc::ByteBuffer(&bytes, 1), {}, nullptr);
    wait();
    grpc::ByteBuffer answer;
    do {
      stream->Read(&answer, nullptr);
    } while (wait());
    grpc::Status status;
    stream->Finish(&status, nullptr);
    wait();
    return status;
  }

  /// Calls `visit` with each method of the contract.
  template <typename Visit>
  static void ForEachMethod(const Visit& visit) {
    for (const auto* request :
         {v1::ListMapsRequest::descriptor(), v1::LocalizeRequest::descriptor(),
          v1::GetServerStateRequest::descriptor(), v1::ListPassesRequest::descriptor()}) {
      const google::protobuf::FileDescriptor* file = request->file();
      for (int s = 0; s < file->service_count(); ++s) {
        for (int m = 0; m < file->service(s)->method_count(); ++m) {
          visit(*file->service(s)->method(m));
        }
      }
    }
  }

  const TestServer server_;
  const std::unique_ptr<IdentityStore> identities_;
};

TEST_F(MethodAccessTest, EachMethodIsForWhomItIs) {
  int denied_count = 0;
  int let_in_count = 0;
  for (const char* tenant : {"", "acme"}) {
    for (const Role role : kRoles) {
      const Principal caller{
          .name = absl::StrCat(NameOf(role), "-1"), .tenant = tenant, .role = role};
      const std::string token = Token(caller);
      ForEachMethod([&](const google::protobuf::MethodDescriptor& method) {
        const bool may = MayCall(caller, method.name());
        if (may && method.name() == "Drain") return;  // the others have yet to ask
        const grpc::Status status = Ask(method, token, caller);
        const std::string who =
            absl::StrCat(method.full_name(), " by ", caller.name, " of \"", tenant, "\"");
        if (may) {
          ++let_in_count;
          EXPECT_NE(status.error_code(), grpc::StatusCode::PERMISSION_DENIED) << who;
          EXPECT_NE(status.error_code(), grpc::StatusCode::UNAUTHENTICATED) << who;
        } else {
          ++denied_count;
          EXPECT_EQ(status.error_code(), grpc::StatusCode::PERMISSION_DENIED)
              << who << ": " << status.error_message();
          EXPECT_THAT(status.error_message(), HasSubstr("needs the permission")) << who;
        }
      });
    }
  }
  EXPECT_GT(denied_count, 50);
  EXPECT_GT(let_in_count, 50);
}

TEST_F(MethodAccessTest, NoMethodIsForWhoDoesNotSayWhoTheyAre) {
  ForEachMethod([&](const google::protobuf::MethodDescriptor& method) {
    EXPECT_EQ(Ask(method, "", {}).error_code(), grpc::StatusCode::UNAUTHENTICATED)
        << method.full_name();
  });
}

}  // namespace
}  // namespace dcloc::server
