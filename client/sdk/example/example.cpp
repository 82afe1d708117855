// A scan to a server, then the pose 100 times a second: example HOST:PORT MAP
#include <chrono>
#include <iostream>
#include <thread>

#include "client/sdk/channel.h"
#include "client/sdk/session.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  dcloc::v1::OpenSession open;
  open.set_vehicle_id("example");
  open.set_map_name(argv[2]);
  auto* radar = open.mutable_rig()->add_radars();
  radar->set_radar_id("front");
  radar->mutable_t_vehicle_radar()->mutable_translation_m()->set_x(3.5);
  radar->mutable_t_vehicle_radar()->mutable_rotation()->set_w(1.0);

  const auto channel = dcloc::client::MakeChannel({.server = argv[1]});
  if (!channel.ok()) return std::cerr << channel.status() << "\n", 1;
  const auto session = dcloc::client::Session::Open(*channel, open);
  if (!session.ok()) return std::cerr << session.status() << "\n", 1;
  dcloc::v1::Scan scan;
  scan.set_radar_id("front");
  scan.set_stamp_ns(1'700'000'000'000'000'000);
  if (const auto sent = (*session)->Send(scan); !sent.ok()) return std::cerr << sent << "\n", 1;
  if (const auto answer = (*session)->Next()) std::cout << answer->DebugString();

  dcloc::v1::EgoVelocity velocity;
  velocity.mutable_linear_mps()->set_x(20.0);
  velocity.mutable_angular_radps();
  std::int64_t now_ns = scan.stamp_ns();
  for (int i = 0; i < 10; ++i, now_ns += 10'000'000) {
    (*session)->AddEgoVelocity(now_ns, velocity).IgnoreError();  // as wheels and gyroscope say
    if (const auto pose = (*session)->SmoothPoseAt(now_ns); pose.ok()) {
      std::cout << "x " << pose->T_map_vehicle.translation_m[0] << "\n";
    } else {
      std::cout << "no pose yet: " << pose.status().message() << "\n";
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  (*session)->CloseSending();
  while (const auto answer = (*session)->Next()) std::cout << answer->DebugString();
  return (*session)->EndStatus().ok() ? 0 : 1;
}
