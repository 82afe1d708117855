#include "core/geometry/geodetic_anchor.h"
#include "server/convert/session.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/server/fixtures/messages.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  v1::OpenSession gnss = server::OpenMessage();
  *gnss.mutable_gnss_fix() = server::GnssFixMessage();
  v1::RadarModel& radar = *gnss.mutable_rig()->add_radars();
  radar = server::RadarMessage("rear");
  radar.set_beta_s(0.04);
  gnss.mutable_options()->set_scans_per_submap(5);
  gnss.mutable_options()->set_doppler_compensation(false);
  return {InputOf(server::OpenMessage().SerializeAsString()), InputOf(gnss.SerializeAsString())};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dcloc;  // NOLINT(google-build-using-namespace)
  v1::OpenSession message;
  if (!message.ParseFromArray(data, static_cast<int>(size))) return 0;
  const auto request = server::convert::FromProto(message);
  if (request.ok()) {
    Require(Validate(request->rig).ok(), "a rig that was taken is valid");
    Require(Validate(request->options).ok(), "options that were taken are valid");
  }
  const GeodeticAnchor anchor{.origin = {.latitude_deg = 52.0, .longitude_deg = 8.0}};
  const auto pose = server::convert::InitialPoseFromProto(message, anchor);
  if (pose.ok() && *pose) Require(Validate(**pose).ok(), "a pose that was taken is valid");
  static_cast<void>(server::convert::InitialPoseFromProto(message, std::nullopt));
  return 0;
}
