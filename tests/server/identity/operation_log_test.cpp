#include "server/identity/operation_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "dcloc/v1/admin_service.pb.h"
#include "dcloc/v1/map_service.pb.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr std::int64_t kAll = std::numeric_limits<std::int64_t>::max();

class OperationLogTest : public ::testing::Test {
 protected:
  OperationLogTest() { spdlog::set_level(spdlog::level::warn); }

  void Note(const std::string& tenant, const google::protobuf::Message& request,
            const absl::Status& status = absl::OkStatus()) {
    log_.Note(context_, {.name = "ann", .tenant = tenant}, request, status);
  }

  grpc::ServerContext context_;
  OperationLog log_;
};

v1::DeleteMapRequest Deletion() {
  v1::DeleteMapRequest request;
  request.set_map_name("town");
  return request;
}

TEST_F(OperationLogTest, KeepsWhatChangesSomething) {
  Note("", v1::ListMapsRequest());
  Note("", Deletion(), absl::NotFoundError("no \"town\"\n"));
  const std::vector<Operation> all = log_.List("", kAll, 10);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].method, "dcloc.v1.MapService.DeleteMap");
  EXPECT_EQ(all[0].principal.name, "ann");
  EXPECT_EQ(all[0].request, "map_name: \"town\"");
  EXPECT_EQ(all[0].code, absl::StatusCode::kNotFound);
  EXPECT_EQ(all[0].message, "no \\\"town\\\"\\n");
}

TEST_F(OperationLogTest, ATenantSeesItsOwn) {
  Note("acme", Deletion());
  Note("", v1::DrainRequest());
  EXPECT_EQ(log_.List("acme", kAll, 10).size(), 1U);
  EXPECT_EQ(log_.List("", kAll, 10).size(), 1U);
  EXPECT_TRUE(log_.List("other", kAll, 10).empty());
}

TEST_F(OperationLogTest, IsBoundedAndKeepsTheNewest) {
  const int count = static_cast<int>(OperationLog::kMaxKept) + 5;
  for (int i = 0; i < count; ++i) Note("", v1::DrainRequest());
  const std::vector<Operation> all = log_.List("", kAll, count);
  ASSERT_EQ(all.size(), OperationLog::kMaxKept);
  EXPECT_EQ(all.front().number, count);
  EXPECT_EQ(log_.List("", all.back().number + 2, count).size(), 2U);
}

TEST_F(OperationLogTest, ATenantPushesOutOnlyItsOwn) {
  Note("", v1::DrainRequest());
  for (std::size_t i = 0; i < 2 * OperationLog::kMaxKept; ++i) Note("acme", Deletion());
  EXPECT_EQ(log_.List("", kAll, 10).size(), 1U);
  EXPECT_EQ(log_.List("acme", kAll, 5000).size(), OperationLog::kMaxKept - 1);
}

TEST_F(OperationLogTest, LongTextIsCutOff) {
  v1::EndSessionRequest request;
  request.set_reason(std::string(100'000, 'x'));
  EXPECT_EQ(OperationLog::TextOf(request), "a message of 100004 bytes");
  request.set_reason(std::string(1'000, 'x'));
  EXPECT_EQ(OperationLog::TextOf(request).size(), OperationLog::kMaxText);
}

}  // namespace
}  // namespace dcloc::server
