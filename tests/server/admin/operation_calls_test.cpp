#include "server/admin/operation_calls.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/server/localization/session_fixture.h"

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

/// The fixture's map was uploaded: the first operation.
class OperationCallsTest : public SessionFixture {
 protected:
  v1::ListOperationsResponse Page(int size, const std::string& token = "") {
    Call call;
    v1::ListOperationsRequest request;
    request.set_page_size(size);
    request.set_page_token(token);
    v1::ListOperationsResponse page;
    EXPECT_TRUE(server_.admin->ListOperations(&call, request, &page).ok());
    return page;
  }

  void End(const std::string& session_id) {
    Call call;
    v1::EndSessionRequest request;
    request.set_session_id(session_id);
    request.set_reason("a\nline");
    v1::EndSessionResponse response;
    server_.admin->EndSession(&call, request, &response);
  }
};

TEST_F(OperationCallsTest, WhatChangedSomethingIsThereNewestFirstAndWhatReadIsNot) {
  const auto session = Connect();
  const std::string id = Open(*session, OpenMessage()).session_id();
  Get(id);
  End(id);
  End("nobody");
  const v1::ListOperationsResponse page = Page(0);
  ASSERT_EQ(page.operations_size(), 3);
  EXPECT_EQ(page.operations(0).method(), "dcloc.v1.AdminService.EndSession");
  EXPECT_EQ(page.operations(0).status_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(page.operations(0).status_message(), HasSubstr("no such session"));
  EXPECT_EQ(page.operations(1).status_code(), grpc::StatusCode::OK);
  EXPECT_THAT(page.operations(1).request(), HasSubstr(id));
  EXPECT_THAT(page.operations(1).request(), HasSubstr("a\\nline")) << "escaped";
  EXPECT_EQ(page.operations(2).method(), "dcloc.v1.MapService.UploadMap");
  EXPECT_THAT(page.operations(2).request(), HasSubstr("town"));
  EXPECT_EQ(page.operations(2).number(), 1);
  EXPECT_EQ(page.operations(2).principal(), "anonymous");
  EXPECT_EQ(page.operations(2).role(), "admin");
  EXPECT_THAT(page.operations(2).peer(), HasSubstr("127.0.0.1"));
  EXPECT_GT(page.operations(2).time().seconds(), 0);
}

TEST_F(OperationCallsTest, PagesFollowOneAnother) {
  for (int i = 0; i < 4; ++i) End("nobody");
  std::vector<std::int64_t> numbers;
  std::string token;
  do {
    const v1::ListOperationsResponse page = Page(2, token);
    for (const v1::Operation& operation : page.operations()) numbers.push_back(operation.number());
    token = page.next_page_token();
  } while (!token.empty());
  EXPECT_THAT(numbers, ::testing::ElementsAre(5, 4, 3, 2, 1));
}

}  // namespace
}  // namespace dcloc::server
