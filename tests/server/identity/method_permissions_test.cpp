#include "server/identity/method_permissions.h"

#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>

#include "dcloc/v1/admin_service.pb.h"
#include "dcloc/v1/localization_service.pb.h"
#include "dcloc/v1/map_service.pb.h"
#include "dcloc/v1/pass_service.pb.h"

namespace dcloc::server {
namespace {

TEST(MethodPermissionsTest, EveryMethodOfTheContractHasExactlyOneEntry) {
  // A static library's descriptors are there once something in it is used.
  for (const auto* used :
       {v1::ListMapsRequest::descriptor(), v1::LocalizeRequest::descriptor(),
        v1::GetServerStateRequest::descriptor(), v1::ListPassesRequest::descriptor()}) {
    ASSERT_NE(used, nullptr);
  }
  std::multiset<std::string> listed;
  for (const MethodPermission& entry : MethodPermissions()) listed.insert(entry.method);
  std::set<std::string> served;
  std::set<const google::protobuf::Descriptor*> requests;
  for (const auto& file : std::filesystem::directory_iterator(DCLOC_PROTO_FOLDER "/dcloc/v1")) {
    const auto* descriptor = google::protobuf::DescriptorPool::generated_pool()->FindFileByName(
        "dcloc/v1/" + file.path().filename().string());
    ASSERT_NE(descriptor, nullptr) << file.path();
    for (int s = 0; s < descriptor->service_count(); ++s) {
      for (int m = 0; m < descriptor->service(s)->method_count(); ++m) {
        const auto* method = descriptor->service(s)->method(m);
        served.insert(method->full_name());
        EXPECT_EQ(listed.count(method->full_name()), 1U)
            << method->full_name() << " needs an entry in method_permissions.cpp";
        EXPECT_TRUE(requests.insert(method->input_type()).second)
            << method->full_name() << " shares its request; permissions are found by request";
      }
    }
  }
  EXPECT_GE(served.size(), 12U);
  for (const std::string& method : listed) EXPECT_TRUE(served.contains(method)) << method;
}

}  // namespace
}  // namespace dcloc::server
