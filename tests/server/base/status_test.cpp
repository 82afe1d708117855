#include "server/base/status.h"

#include <gtest/gtest.h>

#include <string>

namespace dcloc::server {
namespace {

TEST(StatusTest, CodesAndMessagesReachTheCaller) {
  const grpc::Status status = ToGrpc(absl::FailedPreconditionError("the map has no anchor"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(status.error_message(), "the map has no anchor");
  EXPECT_TRUE(ToGrpc(absl::OkStatus()).ok());
}

TEST(StatusTest, WhatAClientSentCannotForgeALineOrFillTheLog) {
  EXPECT_EQ(Quoted("a\nlevel=error \"b\""), "\"a\\nlevel=error \\\"b\\\"\"");
  EXPECT_EQ(Quoted(std::string(80, 'x')), "\"" + std::string(80, 'x') + "\"");
  EXPECT_EQ(Quoted(std::string(1'000, 'x')), "\"" + std::string(80, 'x') + "...\"");
}

TEST(StatusTest, APrefixKeepsTheCodeAndLeavesOkAlone) {
  EXPECT_EQ(WithPrefix("rig: ", absl::NotFoundError("no radar")),
            absl::NotFoundError("rig: no radar"));
  EXPECT_EQ(WithPrefix("rig: ", absl::OkStatus()), absl::OkStatus());
}

}  // namespace
}  // namespace dcloc::server
