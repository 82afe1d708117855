#include "server/tickets/session_tickets.h"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/io/zero_copy_stream_impl_lite.h"
#include "server/base/sha256.h"

namespace dcloc::server {
namespace {

constexpr absl::string_view kFormat = "dct1";
constexpr std::size_t kTimeSize = 8;
constexpr std::size_t kHintSize = 16;  ///< of the binding, by which others' tickets are known
/// By how much the clocks of two servers may differ.
constexpr std::chrono::seconds kMaxClockDifference(30);

std::int64_t Seconds(SystemTime time) {
  return std::chrono::duration_cast<std::chrono::seconds>(time.time_since_epoch()).count();
}

void AppendTime(std::int64_t time_s, std::string* text) {
  for (int shift = 56; shift >= 0; shift -= 8) {
    text->push_back(static_cast<char>((static_cast<std::uint64_t>(time_s) >> shift) & 0xff));
  }
}

/// Takes bytes off the front of a text.
class Reader {
 public:
  explicit Reader(absl::string_view text) : rest_(text) {}

  std::optional<absl::string_view> Take(std::size_t size) {
    if (rest_.size() < size) return std::nullopt;
    const absl::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }
  std::optional<std::int64_t> TakeTime() {
    const auto bytes = Take(kTimeSize);
    if (!bytes) return std::nullopt;
    std::uint64_t time_s = 0;
    for (const char byte : *bytes) time_s = time_s << 8 | static_cast<unsigned char>(byte);
    return static_cast<std::int64_t>(time_s);
  }
  absl::string_view rest() const { return rest_; }

 private:
  absl::string_view rest_;
};

/// What stands in clear before the sealed part.
struct Header {
  std::string key_id;
  std::int64_t issue_s = 0;
  std::int64_t expire_s = 0;
  std::string hint;

  std::string ToBytes() const {
    std::string bytes(kFormat);
    bytes.push_back(static_cast<char>(key_id.size()));
    bytes.append(key_id);
    AppendTime(issue_s, &bytes);
    AppendTime(expire_s, &bytes);
    bytes.append(hint);
    return bytes;
  }
};

std::optional<Header> TakeHeader(Reader& reader) {
  if (reader.Take(kFormat.size()) != kFormat) return std::nullopt;
  const auto id_size = reader.Take(1);
  if (!id_size) return std::nullopt;
  const auto key_id = reader.Take(static_cast<unsigned char>(id_size->front()));
  const auto issue_s = reader.TakeTime();
  const auto expire_s = reader.TakeTime();
  const auto hint = reader.Take(kHintSize);
  if (!key_id || !issue_s || !expire_s || !hint) return std::nullopt;
  if (reader.rest().size() < TicketCipher::kOverhead) return std::nullopt;
  return Header{std::string(*key_id), *issue_s, *expire_s, std::string(*hint)};
}

/// The same bytes for the same message, in every process.
std::string BytesOf(const google::protobuf::Message& message) {
  std::string bytes;
  google::protobuf::io::StringOutputStream stream(&bytes);
  google::protobuf::io::CodedOutputStream coded(&stream);
  coded.SetSerializationDeterministic(true);
  message.SerializePartialToCodedStream(&coded);
  coded.Trim();
  return bytes;
}

bool IsInTime(const Header& header, SystemTime now) {
  const std::int64_t now_s = Seconds(now);
  return header.issue_s <= now_s + kMaxClockDifference.count() && header.expire_s > now_s;
}

}  // namespace

TicketBinding BindingOf(const Principal& principal, const v1::OpenSession& open) {
  Sha256 hash;
  for (const std::string& part : {principal.name, principal.tenant, open.vehicle_id(),
                                  open.map_name(), BytesOf(open.rig()), BytesOf(open.options())}) {
    // The length keeps neighbours apart.
    const std::string bytes = absl::StrCat(part.size(), ":", part);
    hash.Update(std::as_bytes(std::span(bytes)));
  }
  return {absl::HexStringToBytes(hash.Finish())};
}

absl::StatusOr<std::string> SessionTickets::Seal(const TicketContent& content,
                                                 const TicketBinding& binding,
                                                 SystemTime now) const {
  const std::shared_ptr<const TicketCipher> cipher = keys_->cipher();
  const Header header{.key_id = cipher->key_id(),
                      .issue_s = Seconds(now),
                      .expire_s = Seconds(now) + lifetime_.count(),
                      .hint = binding.digest.substr(0, kHintSize)};
  std::string ticket = header.ToBytes();
  const absl::StatusOr<std::string> bytes =
      WriteTicketContent(content, kMaxTicketSize - ticket.size() - TicketCipher::kOverhead);
  if (!bytes.ok()) return bytes.status();
  const absl::StatusOr<std::string> sealed =
      cipher->Seal(*bytes, absl::StrCat(ticket, binding.digest));
  if (!sealed.ok()) return sealed.status();
  ticket.append(*sealed);
  return ticket;
}

OpenedTicket SessionTickets::Open(absl::string_view ticket, const TicketBinding& binding,
                                  SystemTime now) const {
  if (ticket.size() > kMaxTicketSize)
    return {.use = TicketUse::kMalformed, .content = {}, .key_id = ""};
  Reader reader(ticket);
  const std::optional<Header> header = TakeHeader(reader);
  OpenedTicket opened{.use = TicketUse::kMalformed, .content = {}, .key_id = ""};
  if (!header) return opened;
  const std::shared_ptr<const TicketCipher> cipher = keys_->cipher();
  const auto refuse = [&opened](TicketUse use) {
    opened.use = use;
    return opened;
  };
  if (!cipher->has_key(header->key_id)) return refuse(TicketUse::kUnknownKey);
  opened.key_id = header->key_id;
  if (header->hint != binding.digest.substr(0, kHintSize)) return refuse(TicketUse::kForeign);
  const absl::string_view clear = ticket.substr(0, ticket.size() - reader.rest().size());
  const std::optional<std::string> bytes =
      cipher->Open(header->key_id, reader.rest(), absl::StrCat(clear, binding.digest));
  if (!bytes) return refuse(TicketUse::kForged);
  if (!IsInTime(*header, now)) return refuse(TicketUse::kExpired);
  absl::StatusOr<TicketContent> content = ReadTicketContent(*bytes);
  if (!content.ok()) return refuse(TicketUse::kUnusable);
  opened.content = *std::move(content);
  return refuse(TicketUse::kAccepted);
}

}  // namespace dcloc::server
