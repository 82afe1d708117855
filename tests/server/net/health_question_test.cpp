#include "server/net/health_question.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

namespace dcloc::server {
namespace {

/// A server that says what it was given, and then nothing more.
class Scripted : public ProbeBytes {
 public:
  explicit Scripted(std::string says) : says_(std::move(says)) {}

  absl::Status Write(absl::string_view bytes) override {
    heard_.append(bytes.data(), bytes.size());
    return absl::OkStatus();
  }

  absl::Status Read(absl::Span<char> bytes) override {
    if (says_.size() < bytes.size()) return absl::DeadlineExceededError("nothing more comes");
    std::copy_n(says_.begin(), bytes.size(), bytes.begin());
    says_.erase(0, bytes.size());
    return absl::OkStatus();
  }

  const std::string& heard() const { return heard_; }

 private:
  std::string says_;
  std::string heard_;
};

/// A frame of HTTP/2 with a payload of `size` bytes.
std::string Frame(char type, char stream, std::size_t size) {
  std::string bytes(9 + size, '\0');
  bytes[2] = static_cast<char>(size);
  bytes[3] = type;
  bytes[8] = stream;
  return bytes;
}

constexpr char kHeaders = 1;
constexpr char kReset = 3;
constexpr char kSettings = 4;
constexpr char kGoAway = 7;
constexpr char kWindowUpdate = 8;

absl::StatusCode CodeFor(const std::string& says) {
  Scripted server(says);
  return AskHealth(server).code();
}

TEST(HealthQuestionTest, AnAnswerBehindOtherFramesIsEnough) {
  Scripted server(Frame(kSettings, 0, 12) + Frame(kWindowUpdate, 0, 4) + Frame(kHeaders, 1, 30));
  EXPECT_TRUE(AskHealth(server).ok());
  EXPECT_NE(server.heard().find("/grpc.health.v1.Health/Check"), std::string::npos);
}

TEST(HealthQuestionTest, AGreetingAloneIsNone) {
  EXPECT_EQ(CodeFor(Frame(kSettings, 0, 12)), absl::StatusCode::kDeadlineExceeded);
}

TEST(HealthQuestionTest, ARefusalAndAnotherProtocolAreNone) {
  EXPECT_EQ(CodeFor(Frame(kSettings, 0, 0) + Frame(kReset, 1, 4)), absl::StatusCode::kUnavailable);
  EXPECT_EQ(CodeFor(Frame(kSettings, 0, 0) + Frame(kGoAway, 0, 8)), absl::StatusCode::kUnavailable);
  EXPECT_EQ(CodeFor(Frame(kHeaders, 1, 30)), absl::StatusCode::kUnavailable);
  EXPECT_EQ(CodeFor("HTTP/1.1 400 Bad Request\r\n\r\n"), absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace dcloc::server
