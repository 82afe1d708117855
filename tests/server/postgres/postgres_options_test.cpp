#include "server/postgres/postgres_options.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/fixtures/message_of.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

absl::Status Check(const std::string& address) {
  return Validate(PostgresOptions{.address = address});
}

TEST(PostgresOptionsTest, AnAddressIsNoFolder) {
  EXPECT_TRUE(IsPostgresAddress("postgresql://dcloc@db/dcloc"));
  EXPECT_FALSE(IsPostgresAddress("./store"));
  for (const char* address :
       {"", "./store", "host=db", "postgresql://[::1", "postgresql://a?x=1"}) {
    EXPECT_THAT(MessageOf(Check(address)), HasSubstr("postgresql://USER@HOST/DATABASE")) << address;
  }
}

TEST(PostgresOptionsTest, APasswordIsRefusedAndNotRepeated) {
  for (const char* address :
       {"postgresql://dcloc:s3cret@localhost/dcloc", "postgresql://localhost/dcloc?password=s3cret",
        "postgresql://dcloc:s3cret@localhost:port/dcloc"}) {
    const absl::Status status = Check(address);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(MessageOf(status), Not(HasSubstr("s3cret")));
  }
  EXPECT_THAT(MessageOf(Check("postgresql://dcloc:s3cret@localhost/dcloc")),
              AllOf(HasSubstr("password"), HasSubstr("passfile")));
  EXPECT_EQ(ShownAddress("postgresql://dcloc:s3cret@db:5433/maps?sslmode=require"),
            "dcloc@db:5433/maps");
}

TEST(PostgresOptionsTest, AnotherMachineNeedsAWordOnTls) {
  EXPECT_THAT(MessageOf(Check("postgresql://dcloc@db/dcloc")),
              AllOf(HasSubstr("\"db\""), HasSubstr("sslmode")));
  EXPECT_FALSE(Check("postgresql://dcloc@/dcloc?hostaddr=192.0.2.1").ok());
  EXPECT_FALSE(Check("postgresql://dcloc@localhost,db/dcloc").ok());
  EXPECT_TRUE(Check("postgresql://dcloc@db/dcloc?sslmode=verify-full").ok());
  EXPECT_TRUE(Check("postgresql://dcloc@localhost,127.0.0.2/dcloc").ok());
  EXPECT_TRUE(Check("postgresql://dcloc@/dcloc?host=/run/postgresql").ok());
}

}  // namespace
}  // namespace dcloc::server
