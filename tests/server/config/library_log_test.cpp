#include "server/config/library_log.h"

#include <gmock/gmock.h>
#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <gtest/gtest.h>

#include <memory>
#include <sstream>

#include "spdlog/sinks/ostream_sink.h"
#include "spdlog/spdlog.h"

namespace dcloc::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(LibraryLogTest, WhatLibrariesSayIsALineOfOurs) {
  std::ostringstream lines;
  const auto log = std::make_shared<spdlog::logger>(
      "test", std::make_shared<spdlog::sinks::ostream_sink_mt>(lines));
  TakeLibraryMessages(log);
  gpr_log_verbosity_init();
  gpr_log("file.cc", 1, GPR_LOG_SEVERITY_ERROR, "bad\n\"news\"");
  GOOGLE_LOG(ERROR) << "no UTF-8";
  EXPECT_THAT(lines.str(), AllOf(HasSubstr("library=grpc text=\"bad\\n\\\"news\\\"\""),
                                 HasSubstr("library=protobuf text=\"no UTF-8\""),
                                 HasSubstr("warning"), Not(HasSubstr("error"))));
  spdlog::drop("libraries");
}

}  // namespace
}  // namespace dcloc::server
