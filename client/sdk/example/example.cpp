// Scans and ticks to a server, the pose 100 times a second: example HOST:PORT MAP
#include <chrono>
#include <iostream>
#include <thread>

#include "client/sdk/session.h"

using namespace dcloc::client;         // NOLINT(google-build-using-namespace)
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace)

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto session = Session::Connect(
      {.server = argv[1]}, OpenRequest("example", argv[2], {{"front", {3.5, 0.0, 0.5}}}),
      {.unread_answers = UnreadAnswers::kForgetOldest});
  if (!session.ok()) return std::cerr << session.status() << "\n", 1;
  for (int i = 0; i < 100; ++i, std::this_thread::sleep_for(10ms)) {
    const auto now_ns = std::chrono::system_clock::now().time_since_epoch() / 1ns;
    if (i % 5 == 0) (*session)->SendTargets("front", now_ns, {}).IgnoreError();  // as measured
    (*session)->AddMotion({now_ns, 20.0, 0.0}).IgnoreError();  // of wheels and gyroscope
    const auto pose = (*session)->SmoothPoseAt(now_ns);
    if (!pose.ok()) std::cout << "no pose yet: " << pose.status().message() << "\n";
    if (pose.ok()) std::cout << "x " << pose->T_map_vehicle.translation_m[0] << "\n";
  }
  return 0;
}
