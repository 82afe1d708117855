#include "server/config/log.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <mutex>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "nlohmann/json.hpp"
#include "server/base/log_queue.h"
#include "server/base/rate_limit.h"
#include "server/config/library_log.h"
#include "spdlog/pattern_formatter.h"
#include "spdlog/sinks/base_sink.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

constexpr int kLinesPerSecond = 200;
/// Of gRPC and protobuf, which outsiders can make say much.
constexpr int kLibraryLinesPerSecond = 5;
constexpr std::size_t kMaxWaitingLines = 1000;
constexpr char kTextPattern[] = "%Y-%m-%dT%H:%M:%S.%eZ %l %v";
constexpr char kJsonPattern[] = "{\"time\":\"%Y-%m-%dT%H:%M:%S.%eZ\",\"level\":\"%l\",%*}";

std::string JsonText(absl::string_view text) {
  // Bytes that are no UTF-8 are replaced: a log line must never fail.
  return nlohmann::json(std::string(text))
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Takes "key=" off the front of `text`; empty when it does not begin with one.
absl::string_view TakeKey(absl::string_view* text) {
  std::size_t end = 0;
  while (end < text->size() &&
         (absl::ascii_islower(static_cast<unsigned char>((*text)[end])) || (*text)[end] == '_')) {
    ++end;
  }
  if (end == 0 || end == text->size() || (*text)[end] != '=') return {};
  const absl::string_view key = text->substr(0, end);
  text->remove_prefix(end + 1);
  return key;
}

/// Takes a value off the front: up to a space, or a whole quoted text, as `Quoted` writes it.
std::string TakeValue(absl::string_view* text) {
  std::size_t end = 0;
  const bool quoted = !text->empty() && text->front() == '"';
  if (quoted) {
    for (end = 1; end < text->size() && (*text)[end] != '"'; ++end) {
      if ((*text)[end] == '\\') ++end;
    }
    end = std::min(end, text->size());
    std::string value;
    if (!absl::CUnescape(text->substr(1, end - 1), &value)) value = std::string(*text);
    text->remove_prefix(std::min(end + 1, text->size()));
    return value;
  }
  end = std::min(text->find(' '), text->size());
  std::string value(text->substr(0, end));
  text->remove_prefix(end);
  return value;
}

/// "%*" in a pattern: the line as JSON members.
class JsonFlag final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& out) override {
    const std::string members =
        JsonMembers(absl::string_view(message.payload.data(), message.payload.size()));
    out.append(members.data(), members.data() + members.size());
  }
  std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
    return std::make_unique<JsonFlag>();
  }
};

std::unique_ptr<spdlog::formatter> MakeFormatter(bool json) {
  auto formatter = std::make_unique<spdlog::pattern_formatter>(spdlog::pattern_time_type::utc);
  formatter->add_flag<JsonFlag>('*').set_pattern(json ? kJsonPattern : kTextPattern);
  return formatter;
}

/// Without stdio, whose lock a write that is stuck would hold, and the program's end wait for.
class StandardError final : public spdlog::sinks::base_sink<std::mutex> {
 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t line;
    formatter_->format(message, line);
    absl::string_view rest(line.data(), line.size());
    while (!rest.empty()) {
      const ssize_t size = write(STDERR_FILENO, rest.data(), rest.size());
      if (size < 0 && errno == EINTR) continue;
      if (size <= 0) return;
      rest.remove_prefix(static_cast<std::size_t>(size));
    }
  }
  void flush_() override {}
};

class Limited final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  Limited(std::shared_ptr<spdlog::sinks::sink> target, int lines_per_s)
      : sink_(std::move(target)), lines_per_s_(lines_per_s) {}

 protected:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (message.level < spdlog::level::err && !limit_.Take(lines_per_s_, RateLimit::Clock::now())) {
      ++left_out_count_;
      return;
    }
    if (left_out_count_ > 0) {
      const std::string text =
          absl::StrCat("lines left out count=", std::exchange(left_out_count_, 0));
      sink_->log(spdlog::details::log_msg(message.logger_name, spdlog::level::warn, text));
    }
    sink_->log(message);
  }
  void flush_() override { sink_->flush(); }
  void set_pattern_(const std::string& pattern) override { sink_->set_pattern(pattern); }
  void set_formatter_(std::unique_ptr<spdlog::formatter> formatter) override {
    sink_->set_formatter(std::move(formatter));
  }

 private:
  std::shared_ptr<spdlog::sinks::sink> sink_;
  const int lines_per_s_;
  RateLimit limit_;
  long left_out_count_ = 0;
};

}  // namespace

std::string JsonMembers(absl::string_view line) {
  std::string event;
  std::string members;
  while (!line.empty()) {
    const absl::string_view key = TakeKey(&line);
    if (key.empty()) {
      absl::StrAppend(&event, event.empty() ? "" : " ", TakeValue(&line));
    } else {
      absl::StrAppend(&members, ",", JsonText(key), ":", JsonText(TakeValue(&line)));
    }
    line = absl::StripLeadingAsciiWhitespace(line);
  }
  return absl::StrCat("\"event\":", JsonText(event), members);
}

std::shared_ptr<spdlog::sinks::sink> LimitedSink(std::shared_ptr<spdlog::sinks::sink> sink,
                                                 int lines_per_s) {
  return std::make_shared<Limited>(std::move(sink), lines_per_s);
}

void SetUpLog(const ServerConfig& config) {
  const auto lines = QueuedSink(std::make_shared<StandardError>(), kMaxWaitingLines);
  const auto log = [&](int lines_per_s) {
    auto made = std::make_shared<spdlog::logger>("dcloc", LimitedSink(lines, lines_per_s));
    made->set_formatter(MakeFormatter(config.log_format == "json"));
    return made;
  };
  spdlog::set_default_logger(log(kLinesPerSecond));
  TakeLibraryMessages(log(kLibraryLinesPerSecond));
  spdlog::set_level(spdlog::level::from_str(config.log_level));
}

void FlushLog() { spdlog::default_logger()->flush(); }

}  // namespace dcloc::server
