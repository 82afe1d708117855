#include "server/base/peer_wait.h"

#include <gtest/gtest.h>

#include <chrono>

namespace dcloc::server {
namespace {

using std::chrono::milliseconds;

TEST(PeerWaitTest, IsOverdueOnceAfterItsLimit) {
  PeerWait wait;
  const auto now = PeerWait::Clock::now();
  EXPECT_FALSE(wait.TakeOverdue(now + std::chrono::hours(1))) << "nobody is waited for";
  wait.Begin(milliseconds(1000));
  EXPECT_FALSE(wait.TakeOverdue(now));
  EXPECT_TRUE(wait.TakeOverdue(now + milliseconds(2000)));
  EXPECT_FALSE(wait.TakeOverdue(now + milliseconds(3000))) << "once";
  wait.Begin(milliseconds(1000));
  wait.End();
  EXPECT_FALSE(wait.TakeOverdue(now + std::chrono::hours(1)));
}

struct CountedCall : PeerBoundCall {
  void CheckPeer(PeerWait::Clock::time_point /*now*/) override { ++check_count; }
  int check_count = 0;
};

TEST(PeerBoundCallsTest, ChecksThoseThatLive) {
  PeerBoundCalls calls;
  const auto lives = std::make_shared<CountedCall>();
  auto goes = std::make_shared<CountedCall>();
  calls.Add(lives);
  calls.Add(goes);
  goes.reset();
  calls.Check(PeerWait::Clock::now());
  calls.Check(PeerWait::Clock::now());
  EXPECT_EQ(lives->check_count, 2);
}

}  // namespace
}  // namespace dcloc::server
