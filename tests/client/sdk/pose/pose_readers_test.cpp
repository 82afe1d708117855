#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include "client/sdk/pose/pose_tracker.h"
#include "tests/client/sdk/pose/answers.h"

namespace dcloc::client {
namespace {

/// Readers on two threads while two others write. The vehicle stands at x = y, at a place that each
/// answer changes: what is read must be whole.
TEST(PoseReadersTest, WhatIsReadIsWhole) {
  PoseTracker poses({});
  poses.AddAnswer(AnswerAt(0, 0.0));
  std::atomic<bool> ended = false;
  std::atomic<int> newest_ms = 0;
  std::vector<std::jthread> readers;
  readers.reserve(2);
  std::atomic<int> read_count = 0;
  for (int i = 0; i < 2; ++i) {
    readers.emplace_back([&] {
      while (!ended) {
        const std::int64_t stamp_ns = At(newest_ms);
        const auto pose = poses.PoseAt(stamp_ns);
        const auto smooth = poses.SmoothPoseAt(stamp_ns);
        if (!pose.ok() || !smooth.ok()) continue;
        const Vector3& t = pose->T_map_vehicle.translation_m;
        EXPECT_NEAR(t[0], t[1], 1e-9);
        EXPECT_EQ(pose->stamp_ns, stamp_ns);
        EXPECT_NEAR(std::abs(pose->T_map_vehicle.rotation_wxyz[0]), 1.0, 1e-9);
        ++read_count;
      }
    });
  }
  std::jthread wheels([&] {
    for (int ms = 0; !ended; ms = newest_ms) {
      EXPECT_TRUE(poses.AddVelocity(At(ms), Driving(0.0)).ok());
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // leaves the lock to the answers
    }
  });
  for (int ms = 1; ms <= 2000 || read_count < 100; ++ms) {
    v1::LocalizationResult answer = AnswerAt(ms, 0.1 * ms, 0.1 * ms);
    answer.mutable_resets()->set_count(ms);  // nothing but jumps
    poses.AddAnswer(answer);
    newest_ms = ms;
    if (ms % 100 == 0) std::this_thread::yield();
  }
  ended = true;
}

}  // namespace
}  // namespace dcloc::client
