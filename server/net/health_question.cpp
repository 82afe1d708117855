#include "server/net/health_question.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"

namespace dcloc::server {
namespace {

// Frames of HTTP/2 (RFC 9113, 4.1 and 6).
constexpr std::size_t kFrameHeaderSize = 9;
constexpr std::size_t kMaxFrameSize = std::size_t{1} << 14;
enum FrameType : std::uint8_t { kData = 0, kHeaders = 1, kReset = 3, kSettings = 4, kGoAway = 7 };
constexpr std::uint8_t kEndStream = 1;
constexpr std::uint8_t kEndHeaders = 4;
constexpr std::uint8_t kOurStream = 1;

struct Frame {
  std::size_t size = 0;  ///< of the payload [bytes]
  std::uint8_t type = 0;
  std::uint8_t stream = 0;  ///< the last of its four bytes: we have no other stream than 1
};

/// With a payload below 256 bytes.
std::string FrameBytes(FrameType type, std::uint8_t flags, std::uint8_t stream,
                       absl::string_view payload) {
  std::string bytes(kFrameHeaderSize, '\0');
  bytes[2] = static_cast<char>(payload.size());
  bytes[3] = static_cast<char>(type);
  bytes[4] = static_cast<char>(flags);
  bytes[8] = static_cast<char>(stream);
  absl::StrAppend(&bytes, payload);
  return bytes;
}

/// A literal field that no table keeps (RFC 7541, 6.2.2), of short texts.
std::string Field(absl::string_view name, absl::string_view value) {
  std::string bytes(1, '\0');
  for (const absl::string_view text : {name, value}) {
    bytes.push_back(static_cast<char>(text.size()));
    absl::StrAppend(&bytes, text);
  }
  return bytes;
}

std::string Question() {
  const std::string fields =
      absl::StrCat(Field(":method", "POST"), Field(":scheme", "http"),
                   Field(":path", "/grpc.health.v1.Health/Check"), Field(":authority", "localhost"),
                   Field("content-type", "application/grpc"), Field("te", "trailers"));
  const std::string empty_message(5, '\0');  // not compressed, and four bytes of length
  return absl::StrCat("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", FrameBytes(kSettings, 0, 0, ""),
                      FrameBytes(kHeaders, kEndHeaders, kOurStream, fields),
                      FrameBytes(kData, kEndStream, kOurStream, empty_message));
}

absl::Status ReadFrame(ProbeBytes& connection, Frame& frame) {
  std::array<char, kFrameHeaderSize> header{};
  if (absl::Status status = connection.Read(absl::MakeSpan(header)); !status.ok()) return status;
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(header[i]); };
  frame.size = std::size_t{byte(0)} << 16 | std::size_t{byte(1)} << 8 | byte(2);
  frame.type = byte(3);
  frame.stream = byte(8);
  if (frame.size > kMaxFrameSize) {
    return absl::UnavailableError("the server speaks, but not HTTP/2");
  }
  std::vector<char> payload(frame.size);
  return connection.Read(absl::MakeSpan(payload));
}

}  // namespace

absl::Status AskHealth(ProbeBytes& connection) {
  // The server speaks first. One that wants a certificate says so instead, and closes: what is
  // written then is written to nobody.
  Frame frame;
  if (absl::Status status = ReadFrame(connection, frame); !status.ok()) return status;
  if (frame.type != kSettings) {
    return absl::UnavailableError("the server speaks, but not HTTP/2");
  }
  if (absl::Status status = connection.Write(Question()); !status.ok()) return status;
  while (true) {
    if (absl::Status status = ReadFrame(connection, frame); !status.ok()) return status;
    if (frame.type == kGoAway) return absl::UnavailableError("the server takes no calls");
    if (frame.stream != kOurStream) continue;
    if (frame.type == kHeaders) return absl::OkStatus();
    if (frame.type == kReset) return absl::UnavailableError("the server refused a call");
  }
}

}  // namespace dcloc::server
