#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>

#include "tests/client/cli/fixtures/admin_commands.h"

// `dcloc session`.
namespace dcloc::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

using SessionCommandTest = AdminCommands;

TEST_F(SessionCommandTest, SessionsAreListedAndShown) {
  const auto first = OpenSession("car-1");
  const auto second = OpenSession("car-2");
  ASSERT_TRUE(second->Localize(server::ScanMessage(4))->has_result());
  const json all = json::parse(Dcloc(At("session list") + "--json").out);
  EXPECT_EQ(all.size(), 2U);
  const json one = json::parse(Dcloc(At("session list") + "--vehicle car-2 --json").out);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_EQ(one[0]["session_id"], ids_[1]);
  EXPECT_EQ(one[0]["scan_count"], 1);
  EXPECT_EQ(one[0]["last_sequence_number"], 4);
  EXPECT_EQ(one[0]["state"], "dead_reckoning");
  const Result table = Dcloc(At("session list"));
  EXPECT_THAT(table.out, AllOf(HasSubstr("car-1"), HasSubstr("car-2"), HasSubstr("town:1"),
                               HasSubstr("dead_reckoning"), HasSubstr(ids_[0].substr(0, 8))));
  for (const std::string& name : {ids_[1], ids_[1].substr(0, 10), std::string("car-2")}) {
    const Result shown = Dcloc(At("session show") + name + " --json");
    ASSERT_EQ(shown.exit_code, 0) << shown.err;
    EXPECT_EQ(json::parse(shown.out)["session_id"], ids_[1]);
  }
  EXPECT_THAT(Dcloc(At("session show") + "car-2").out, HasSubstr(ids_[1]));
}

TEST_F(SessionCommandTest, ANameThatIsNotOneSessionsIsAnError) {
  const auto first = OpenSession("car-1");
  const auto second = OpenSession("car-1");
  const Result two = Dcloc(At("session show") + "car-1");
  EXPECT_EQ(two.exit_code, 1);
  EXPECT_THAT(two.err, AllOf(HasSubstr(ids_[0]), HasSubstr(ids_[1])));
  const Result none = Dcloc(At("session end") + "car-7");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("car-7"));
  EXPECT_EQ(Dcloc(At("session show")).exit_code, 2);
}

TEST_F(SessionCommandTest, APoseIsProposed) {
  const auto session = OpenSession("car-1");
  const std::string propose = At("session propose") + "car-1 --x 12 --y -3 ";
  const Result early = Dcloc(propose);
  EXPECT_EQ(early.exit_code, 1);
  EXPECT_THAT(early.err, HasSubstr("no scan"));
  ASSERT_TRUE(session->Localize(server::ScanMessage(0)).has_value());
  const json answer = json::parse(Dcloc(propose + "--yaw-deg 90 --json").out);
  EXPECT_EQ(answer["session_id"], ids_[0]);
  EXPECT_EQ(answer["stamp_ns"], server::ScanMessage(0).stamp_ns());
  EXPECT_EQ(answer["use"], "contradicted") << "by the stub";
  EXPECT_THAT(Dcloc(propose).out, HasSubstr("contradicted"));
  EXPECT_EQ(Dcloc(propose + "--sigma-m 0").exit_code, 2);
  EXPECT_EQ(Dcloc(At("session propose") + "car-1 --x 12").exit_code, 2);
}

TEST_F(SessionCommandTest, AnswersAreWatched) {
  const auto session = OpenSession("car-1");
  DclocProcess watch(At("session watch") + "car-1 --json --count 2");
  // Until the watcher is there, answers pass it by.
  for (int i = 0; !watch.HasEnded(); ++i) {
    ASSERT_TRUE(session->Localize(server::ScanMessage(i)).has_value());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const Result result = watch.Wait();
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream lines(result.out);
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  const json first = json::parse(line);
  EXPECT_EQ(first["state"], "dead_reckoning");
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(json::parse(line)["sequence_number"], first["sequence_number"].get<int>() + 1);
  EXPECT_FALSE(std::getline(lines, line));
}

TEST_F(SessionCommandTest, CtrlCEndsAWatchWell) {
  const auto session = OpenSession("car-1");
  DclocProcess watch(At("session watch") + "car-1");
  for (int i = 0; watch.Out().empty(); ++i) {
    ASSERT_TRUE(session->Localize(server::ScanMessage(i)).has_value());
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  watch.Signal(SIGINT);
  const Result result = watch.Wait();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("dead_reckoning"));
}

TEST_F(SessionCommandTest, ASessionIsEndedWithAReason) {
  const auto session = OpenSession("car-1");
  const Result result = Dcloc(At("session end") + "car-1 --reason \"radar misaligned\"");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const grpc::Status status = session->Finish();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
  EXPECT_THAT(status.error_message(), HasSubstr("radar misaligned"));
  const Result gone = Dcloc(At("session show") + ids_[0]);
  EXPECT_EQ(gone.exit_code, 1);
  EXPECT_THAT(gone.err, HasSubstr("radar misaligned")) << "why it ended is still known";
}

}  // namespace
}  // namespace dcloc::cli
