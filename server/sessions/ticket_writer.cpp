#include "server/sessions/ticket_writer.h"

#include <chrono>
#include <utility>

#include "server/base/status.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {

std::optional<AnswerTicket> TicketWriter::OnAnswered(std::int64_t sequence_number,
                                                     const LocalizedScan& scan,
                                                     const MapVersionRecord& map,
                                                     ScanLocalizer& localizer) {
  if (!writes()) return std::nullopt;
  // A late scan, or one after a clock was set back, makes no difference of a second.
  const Stamp stamp = scan.localization.stamp;
  if (last_look_ && stamp >= *last_look_ && stamp - *last_look_ < tickets_->interval()) {
    return std::nullopt;
  }
  last_look_ = stamp;
  std::optional<TicketContent> before = std::exchange(pending_, std::nullopt);
  std::optional<LocalizerSnapshot> snapshot = localizer.Snapshot();
  if (!snapshot) return std::nullopt;
  snapshot->resets = scan.localization.resets;
  pending_ = {.map_version = map.version,
              .map_sha256 = map.sha256,
              .epoch = info_->description.epoch,
              .last_sequence_number = sequence_number,
              .session_id = info_->description.session_id,
              .snapshot = *std::move(snapshot)};
  const bool was_right = before && before->snapshot.resets.count == scan.localization.resets.count;
  return was_right ? Seal(*before) : std::nullopt;
}

std::optional<AnswerTicket> TicketWriter::Seal(const TicketContent& content) const {
  absl::StatusOr<std::string> sealed =
      tickets_->Seal(content, binding_, std::chrono::system_clock::now());
  if (!sealed.ok()) {
    spdlog::debug("ticket not made session={} reason={}", info_->description.session_id,
                  Quoted(sealed.status().message()));
    return std::nullopt;
  }
  return AnswerTicket{.sealed = *std::move(sealed),
                      .last_sequence_number = content.last_sequence_number};
}

}  // namespace dcloc::server
