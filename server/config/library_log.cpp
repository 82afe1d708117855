#include "server/config/library_log.h"

#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>

#include <string>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/string_view.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

/// The handlers of the libraries are plain functions, so spdlog's registry has the logger.
constexpr char kLogger[] = "libraries";
constexpr std::size_t kMaxText = 500;

void LogMessage(const char* library, spdlog::level::level_enum level, absl::string_view text) {
  const std::shared_ptr<spdlog::logger> log = spdlog::get(kLogger);
  if (log == nullptr) return;
  log->log(level, "library message library={} text=\"{}\"", library,
           absl::CHexEscape(text.substr(0, kMaxText)));
}

void TakeGrpcMessage(gpr_log_func_args* message) {
  LogMessage(
      "grpc",
      message->severity == GPR_LOG_SEVERITY_ERROR ? spdlog::level::warn : spdlog::level::debug,
      message->message);
}

void TakeProtobufMessage(google::protobuf::LogLevel level, const char* /*file*/, int /*line*/,
                         const std::string& message) {
  LogMessage(
      "protobuf",
      level >= google::protobuf::LOGLEVEL_WARNING ? spdlog::level::warn : spdlog::level::debug,
      message);
}

}  // namespace

void TakeLibraryMessages(const std::shared_ptr<spdlog::logger>& log) {
  spdlog::drop(kLogger);
  spdlog::register_logger(log->clone(kLogger));
  gpr_set_log_function(&TakeGrpcMessage);
  google::protobuf::SetLogHandler(&TakeProtobufMessage);
}

}  // namespace dcloc::server
