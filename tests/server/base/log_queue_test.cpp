#include "server/base/log_queue.h"

#include <gtest/gtest.h>

#include <chrono>
#include <latch>
#include <memory>
#include <mutex>
#include <string>

#include "absl/strings/str_cat.h"
#include "spdlog/sinks/base_sink.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

/// Takes nothing until it is let go.
class StuckSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  std::latch writing{1};
  std::latch let_go{1};
  std::string text;

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (text.empty()) writing.count_down();
    let_go.wait();
    absl::StrAppend(&text, std::string(message.payload.data(), message.payload.size()), "\n");
  }
  void flush_() override {}
};

TEST(QueuedSinkTest, WhoLogsDoesNotWaitForASinkThatIsStuck) {
  const auto stuck = std::make_shared<StuckSink>();
  {
    spdlog::logger log("test", QueuedSink(stuck, 3));
    log.info("line 0");
    stuck->writing.wait();
    const auto begin = std::chrono::steady_clock::now();
    for (int i = 1; i <= 10; ++i) log.info("line {}", i);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(500));
    stuck->let_go.count_down();
  }
  EXPECT_EQ(stuck->text, "line 0\nlines left out count=7\nline 8\nline 9\nline 10\n");
}

TEST(QueuedSinkTest, TheEndDoesNotWaitForGood) {
  const auto stuck = std::make_shared<StuckSink>();
  const auto begin = std::chrono::steady_clock::now();
  {
    spdlog::logger log("test", QueuedSink(stuck, 3));
    log.info("line");
    log.flush();
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  stuck->let_go.count_down();
}

}  // namespace
}  // namespace dcloc::server
