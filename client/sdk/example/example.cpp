// One scan to a server, its pose back: example HOST:PORT MAP
#include <iostream>

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
  (*session)->CloseSending();
  while (const auto answer = (*session)->Next()) std::cout << answer->DebugString();
  return (*session)->EndStatus().ok() ? 0 : 1;
}
