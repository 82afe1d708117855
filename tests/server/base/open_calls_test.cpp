#include "server/base/open_calls.h"

#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <thread>
#include <utility>

namespace dcloc::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

TEST(OpenCallsTest, AShutdownWaitsForTheLastCall) {
  OpenCalls calls;
  calls.WaitUntilNone();  // none runs: at once
  std::optional<OpenCalls::Token> first(std::in_place, calls);
  OpenCalls::Token second(calls);
  OpenCalls::Token moved = std::move(second);  // still one call
  std::atomic<bool> over = false;
  std::jthread waiter([&] {
    calls.WaitUntilNone();
    over = true;
  });
  first.reset();
  calls.WaitUntilNone(steady_clock::now() + milliseconds(20));
  EXPECT_FALSE(over);
  { const OpenCalls::Token last = std::move(moved); }
  waiter.join();
  EXPECT_TRUE(over);
}

TEST(OpenCallsTest, ADeadlineEndsTheWait) {
  OpenCalls calls;
  const OpenCalls::Token call(calls);
  const auto deadline = steady_clock::now() + milliseconds(20);
  calls.WaitUntilNone(deadline);
  EXPECT_GE(steady_clock::now(), deadline);
}

}  // namespace
}  // namespace dcloc::server
