#include "server/tickets/served_ticket_keys.h"

#include <chrono>
#include <utility>

#include "absl/strings/escaping.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr std::chrono::seconds kInterval(1);

}  // namespace

absl::StatusOr<std::unique_ptr<ServedTicketKeys>> ServedTicketKeys::Load(
    const std::filesystem::path& file) {
  absl::StatusOr<std::vector<TicketKey>> keys = ReadTicketKeys(file);
  if (!keys.ok()) return keys.status();
  auto cipher = TicketCipher::Create(*std::move(keys));
  if (!cipher.ok()) return cipher.status();
  std::unique_ptr<ServedTicketKeys> served(new ServedTicketKeys(file, *std::move(cipher)));
  served->ticker_ = std::make_unique<Ticker>(kInterval, [keys = served.get()] { keys->Refresh(); });
  return served;
}

ServedTicketKeys::ServedTicketKeys(std::filesystem::path file,
                                   std::shared_ptr<const TicketCipher> cipher)
    : file_(std::move(file)), last_look_(cipher->keys()) {
  spdlog::info("ticket keys taken seals={} keys={}", cipher->key_id(), cipher->keys().size());
  cipher_ = std::move(cipher);
}

void ServedTicketKeys::Refresh() {
  absl::StatusOr<std::vector<TicketKey>> found = ReadTicketKeys(file_);
  if (found == last_look_) Take(found);
  last_look_ = std::move(found);
}

void ServedTicketKeys::Take(const absl::StatusOr<std::vector<TicketKey>>& found) {
  absl::Status fault = found.status();
  if (found.ok() && *found != cipher()->keys()) {
    auto cipher = TicketCipher::Create(*found);
    fault = cipher.status();
    if (cipher.ok()) {
      cipher_.store(*cipher);
      spdlog::info("ticket keys taken seals={} keys={}", (*cipher)->key_id(),
                   (*cipher)->keys().size());
    }
  }
  if (!fault.ok() && fault != last_fault_) {
    spdlog::error("ticket keys not taken reason=\"{}\" seals={}", absl::CHexEscape(fault.message()),
                  cipher()->key_id());
  }
  last_fault_ = fault;
}

}  // namespace dcloc::server
