#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "core/geometry/geodetic_anchor.h"
#include "core/localizer/localizer.h"
#include "dcloc/v1/localization_service.pb.h"

namespace dcloc::server {

/// Durations of a scan's stages; zero for a stage that did not run.
struct ScanTimings {
  std::chrono::nanoseconds queue{};       ///< from the scan's arrival until a worker took it
  std::chrono::nanoseconds conversion{};  ///< checking and converting the message
  std::chrono::nanoseconds compensation{};
  std::chrono::nanoseconds submap{};
  std::chrono::nanoseconds registration{};
  std::chrono::nanoseconds posegraph{};
  std::chrono::nanoseconds total{};      ///< from the scan's arrival until its answer was known
  std::chrono::nanoseconds stamp_age{};  ///< arrival by the server's wall clock, minus the stamp
};

/// A scan that was localized.
struct LocalizedScan {
  std::int64_t map_version = 0;
  Localization localization;
  std::shared_ptr<const Rig> rig;        ///< names the radars of its health; may be null
  std::optional<GeodeticAnchor> anchor;  ///< of the map; without one there is no geodetic pose
  ScanTimings timings;
};

/// What a client goes on with elsewhere, should this server be gone.
struct AnswerTicket {
  std::string sealed;
  std::int64_t last_sequence_number = 0;
};

/// The result of one scan, as a plain struct, so that its users need no message.
struct ScanAnswer {
  std::int64_t sequence_number = -1;
  absl::StatusOr<LocalizedScan> result;  ///< or why the scan was rejected
  std::int64_t dropped_scan_count = 0;   ///< of the session, so far
  bool from_memory = false;              ///< the scan was sent again
  /// For the vehicle alone: who watches or records it gets none.
  std::optional<AnswerTicket> ticket;
};

namespace convert {

/// Sets every field, so that nothing of what `message` held before shows through; its memory is
/// used again.
void ToProto(const ScanAnswer& answer, v1::LocalizeResponse* message);

/// Everything of the answer but the sequence number, the version, the timings, the geodetic pose
/// and the health.
void ToProto(const Localization& localization, v1::LocalizationResult* message);

/// `rig` is the one that `health` is of.
void ToProto(const Health& health, const Rig& rig, v1::Health* message);

v1::LocalizationState ToProto(LocalizationState state);

}  // namespace convert
}  // namespace dcloc::server
