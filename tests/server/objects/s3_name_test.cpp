#include <dlfcn.h>
#include <gtest/gtest.h>
#include <netdb.h>

#include <atomic>
#include <chrono>
#include <string>
#include <string_view>
#include <thread>

#include "absl/strings/str_cat.h"
#include "server/objects/s3_client.h"
#include "tests/server/fixtures/messages.h"
#include "tests/server/fixtures/s3_stub.h"

namespace {

/// What becomes of lookups of names that end with ".dcloc.example".
enum class Names { kKnown, kElsewhere, kGone, kSilent };
std::atomic<Names> names = Names::kKnown;
constexpr std::chrono::seconds kSilence(6);

using Lookup = int (*)(const char*, const char*, const addrinfo*, addrinfo**);

int LookUp(const char* host, const char* service, const addrinfo* hints, addrinfo** found) {
  static const auto next = reinterpret_cast<Lookup>(dlsym(RTLD_NEXT, "getaddrinfo"));
  if (host == nullptr || !std::string_view(host).ends_with(".dcloc.example")) {
    return next(host, service, hints, found);
  }
  if (names == Names::kSilent) std::this_thread::sleep_for(kSilence);
  if (names == Names::kGone || names == Names::kSilent) return EAI_AGAIN;
  return next(names == Names::kKnown ? "127.0.0.1" : "127.0.0.2", service, hints, found);
}

}  // namespace

/// In the place of the system's, for all libraries of this program.
extern "C" int getaddrinfo(const char* host, const char* service, const addrinfo* hints,
                           addrinfo** found) {
  return LookUp(host, service, hints, found);
}

// An object store whose name cannot be resolved is away, nobody waits long for it, and it is back
// with its name.
namespace dcloc::server {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

class S3NameTest : public ::testing::Test {
 protected:
  S3NameTest() {
    stub_.Put("site/a", "abc");
    const std::string endpoint = stub_.Options().endpoint;
    url_ = absl::StrCat("http://objects.dcloc.example", endpoint.substr(endpoint.rfind(':')),
                        "/maps/site/a");
  }
  ~S3NameTest() override { names = Names::kKnown; }

  absl::Status Ask() {
    const auto credentials = ReadObjectCredentials("");
    if (!credentials.ok()) return credentials.status();
    return client_.Send({.method = "GET", .url = url_, .timeout = 5s}, Sha256Of({}), *credentials)
        .status();
  }

  /// Whether it answers within the time of a recovery.
  bool IsBack() {
    for (const Clock::time_point begin = Clock::now(); Clock::now() - begin < 5s;) {
      if (Ask().ok()) return true;
      std::this_thread::sleep_for(200ms);
    }
    return false;
  }

  S3Stub stub_;
  std::string url_;
  S3Client client_{{.region = "us-east-1", .connect_timeout = 1s, .pause_timeout = 2s}};
};

TEST_F(S3NameTest, IsBackWithItsName) {
  names = Names::kGone;
  EXPECT_TRUE(absl::IsUnavailable(Ask()));
  names = Names::kKnown;
  EXPECT_TRUE(Ask().ok());
}

TEST_F(S3NameTest, ASilentNameServerHoldsUpNobodyForLong) {
  names = Names::kSilent;
  const Clock::time_point begin = Clock::now();
  EXPECT_TRUE(absl::IsUnavailable(Ask()));
  EXPECT_LT(Clock::now() - begin, 3s);
  names = Names::kKnown;
  EXPECT_TRUE(IsBack());
}

TEST_F(S3NameTest, IsFoundWhereItHasMovedTo) {
  names = Names::kElsewhere;
  EXPECT_TRUE(absl::IsUnavailable(Ask()));
  names = Names::kKnown;
  EXPECT_TRUE(IsBack());
}

}  // namespace
}  // namespace dcloc::server
