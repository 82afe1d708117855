#include "server/net/call_gate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

constexpr char kPath[] = "/dcloc.v1.LocalizationService/Localize";

TEST(CallGateTest, AConnectionBeginsOnlySoManyCallsASecond) {
  CallGate gate(10);
  const int one = 0;
  const int other = 0;
  const auto now = RateLimit::Clock::now();
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(gate.Admit(&one, kPath, false, now).ok());
  const absl::Status status = gate.Admit(&one, kPath, true, now);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(status.message()), HasSubstr("max_call_rate_hz_per_connection"));
  EXPECT_TRUE(gate.Admit(&other, kPath, false, now).ok()) << "others are not held back";
  EXPECT_TRUE(gate.Admit(&one, kPath, false, now + std::chrono::seconds(1)).ok());
  EXPECT_EQ(gate.refused().too_fast, 1);
}

TEST(CallGateTest, NoneBeginsWhileMemoryIsShortButTheAskingForHealth) {
  MemoryReserve reserve;
  CallGate gate(0, reserve);
  const auto now = RateLimit::Clock::now();
  ASSERT_TRUE(reserve.Keep(1 << 20));
  EXPECT_TRUE(gate.Admit(&gate, kPath, true, now).ok());
  reserve.Give();
  EXPECT_EQ(gate.Admit(&gate, kPath, true, now).code(), absl::StatusCode::kResourceExhausted);
  EXPECT_TRUE(gate.Admit(&gate, "/grpc.health.v1.Health/Check", false, now).ok());
  EXPECT_EQ(gate.refused().out_of_memory, 1);
  ASSERT_TRUE(reserve.Tend());
  EXPECT_TRUE(gate.Admit(&gate, kPath, true, now).ok());
}

TEST(CallGateTest, WithoutALimitAllBegin) {
  CallGate gate(0);
  const auto now = RateLimit::Clock::now();
  for (int i = 0; i < 10'000; ++i) ASSERT_TRUE(gate.Admit(&gate, kPath, false, now).ok());
}

TEST(CallGateTest, AProofIsNeededOnceThereAreIdentitiesButNotForHealthAndReflection) {
  CallGate gate(0);
  const auto now = RateLimit::Clock::now();
  EXPECT_TRUE(gate.Admit(&gate, kPath, false, now).ok());
  gate.SetProofNeeded(true);
  EXPECT_EQ(gate.Admit(&gate, kPath, false, now).code(), absl::StatusCode::kUnauthenticated);
  EXPECT_EQ(gate.refused().without_proof, 1);
  EXPECT_TRUE(gate.Admit(&gate, kPath, true, now).ok());
  for (const char* path : {"/grpc.health.v1.Health/Check",
                           "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo"}) {
    EXPECT_TRUE(gate.Admit(&gate, path, false, now).ok()) << path;
  }
}

}  // namespace
}  // namespace dcloc::server
