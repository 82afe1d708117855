// `dcloc doctor` on servers and data that are well, and on others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "client/datasets/dataset.h"
#include "client/datasets/export_bag.h"
#include "server/app/storage.h"
#include "tests/client/cli/fixtures/server_commands.h"
#include "tests/server/fixtures/test_certificates.h"

namespace dcloc {
namespace {

using Json = nlohmann::json;
using ::testing::HasSubstr;

/// "ok", "warning", ... of a check; empty where it was not made.
std::string ResultOf(const Json& report, const std::string& check) {
  for (const Json& entry : report["checks"]) {
    if (entry["check"] == check) return entry["result"];
  }
  return "";
}

std::string WhatOf(const Json& report, const std::string& check) {
  for (const Json& entry : report["checks"]) {
    if (entry["check"] == check) {
      return entry["what"].get<std::string>() + " -> " + entry["advice"].get<std::string>();
    }
  }
  return "";
}

class DoctorCommandTest : public ServerCommands {
 protected:
  /// The report of `doctor WORDS`; the exit code is that of the result.
  static Json Doctor(const std::string& words) {
    const Result result = Dcloc("doctor --json " + words);
    Json report = Json::parse(result.out, nullptr, /*allow_exceptions=*/false);
    EXPECT_FALSE(report.is_discarded()) << result.out << result.err;
    const int expected = report["result"] == "failed" ? 1 : report["result"] == "warning" ? 3 : 0;
    EXPECT_EQ(result.exit_code, expected) << result.out;
    return report;
  }
  Json DoctorHere(const std::string& words) const {
    return Doctor("--server " + address_ + " " + words);
  }

  /// A server with certificates of `authority` in place of the other one.
  void ServeTls(const server::TestCertificate& certificate) {
    certificate.Write(folder_.path(), "server");
    server_.reset();
    auto server = server::Server::Start({.data = File("tls-data"),
                                         .listen = "127.0.0.1:0",
                                         .tls_cert = File("server.pem"),
                                         .tls_key = File("server.key"),
                                         .log_level = "error"});
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    address_ = server_->address();
  }
};

TEST_F(DoctorCommandTest, AServerThatIsWellIsFoundSo) {
  Upload();
  const Json report = DoctorHere("--map town --open-session " + Data());
  for (const char* check : {"connection", "TLS", "gRPC", "server", "map", "session", "clock"}) {
    EXPECT_EQ(ResultOf(report, check), "ok") << WhatOf(report, check);
  }
  EXPECT_EQ(ResultOf(report, "drive in map"), "ok") << WhatOf(report, "drive in map");
  EXPECT_EQ(ResultOf(report, "rights"), "warning") << "everybody may do everything";
  EXPECT_THAT(WhatOf(report, "rights"), HasSubstr("token create"));
  EXPECT_EQ(Json::parse(Dcloc(At("session list") + "--json").out).size(), 0U);
}

TEST_F(DoctorCommandTest, WhatIsMissingIsNamedWithWhatToDo) {
  EXPECT_THAT(WhatOf(DoctorHere("--map town"), "map"), HasSubstr("map upload"));
  Upload();
  const Json far = DoctorHere("--map town --at 90000,0");
  EXPECT_EQ(ResultOf(far, "place"), "failed");
  EXPECT_THAT(WhatOf(far, "place"), HasSubstr("this map's frame"));
  EXPECT_THAT(WhatOf(DoctorHere("--map town --at 900,2000"), "place"), HasSubstr(" m from mapped"));
  const Json nobody = Doctor("--server 127.0.0.1:1 --map town");
  EXPECT_EQ(ResultOf(nobody, "connection"), "failed");
  EXPECT_EQ(ResultOf(nobody, "rights, clock, map"), "skipped");
  const Result people = Dcloc("doctor --server 127.0.0.1:1");
  EXPECT_THAT(people.out, HasSubstr("failed   connection"));
  EXPECT_THAT(people.out, HasSubstr("-> is dcloc-server running"));
  EXPECT_EQ(Dcloc("doctor").exit_code, 2);
  EXPECT_EQ(Dcloc("doctor --server 127.0.0.1:1 --at 1,2").exit_code, 2) << "in no map";
}

TEST_F(DoctorCommandTest, TheRoleOfATokenIsTold) {
  Upload();
  const auto identities = *server::OpenIdentities(folder_.path() / "data");
  const auto token = [&](const char* name, server::Role role) {
    std::ofstream(File(name)) << *identities->Create(server::Proof::kToken,
                                                     {.name = name, .role = role}, {});
    return std::string("--token-file ") + File(name) + " ";
  };
  const std::string car = token("car", server::Role::kVehicle);
  EXPECT_THAT(WhatOf(DoctorHere(car), "rights"), HasSubstr("vehicle: may localize, read_coverage"));
  EXPECT_THAT(WhatOf(DoctorHere(token("eye", server::Role::kViewer)), "rights"),
              HasSubstr("viewer: may read_coverage, read_maps"));
  const std::string ops = token("ops", server::Role::kOperator);
  EXPECT_EQ(ResultOf(DoctorHere(ops), "rights"), "ok");
  EXPECT_THAT(WhatOf(DoctorHere(ops), "rights"), HasSubstr("operator or admin"));
  EXPECT_THAT(WhatOf(DoctorHere(""), "rights"), HasSubstr("--token-file"));
  std::ofstream(File("false")) << "dcloc_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA";
  EXPECT_EQ(ResultOf(DoctorHere("--token-file " + File("false")), "rights"), "failed");

  const Json other = DoctorHere(car + "--map town --open-session");
  EXPECT_EQ(ResultOf(other, "session"), "failed");
  EXPECT_THAT(WhatOf(other, "session"), HasSubstr("--vehicle"));
  const Json own = DoctorHere(car + "--map town --open-session --vehicle car");
  EXPECT_EQ(ResultOf(own, "session"), "ok") << WhatOf(own, "session");
}

TEST_F(DoctorCommandTest, ACertificateIsJudged) {
  const auto authority = server::TestCertificate::Authority("authority");
  authority.Write(folder_.path(), "authority");
  server::TestCertificate::Authority("other").Write(folder_.path(), "other");
  ServeTls(server::TestCertificate::ValidFor(authority, "server", -30, 60));
  const std::string ca = "--tls-ca " + File("authority.pem") + " ";
  Json report = DoctorHere(ca);
  EXPECT_EQ(ResultOf(report, "certificate"), "ok") << WhatOf(report, "certificate");
  EXPECT_EQ(ResultOf(report, "certificate dates"), "ok");
  EXPECT_EQ(ResultOf(report, "gRPC"), "ok");
  EXPECT_THAT(WhatOf(DoctorHere(""), "TLS"), HasSubstr("--tls-ca"));
  report = DoctorHere("--tls-ca " + File("other.pem"));
  EXPECT_EQ(ResultOf(report, "certificate"), "failed");
  EXPECT_THAT(WhatOf(report, "certificate"), HasSubstr("give the authority that signed it"));
  report = DoctorHere(ca + "--tls-server-name elsewhere");
  EXPECT_EQ(ResultOf(report, "certificate"), "failed");
  EXPECT_THAT(WhatOf(report, "certificate"), HasSubstr("not for elsewhere"));

  ServeTls(server::TestCertificate::ValidFor(authority, "server", -30, 5));
  report = DoctorHere(ca);
  EXPECT_EQ(ResultOf(report, "certificate dates"), "warning");
  EXPECT_THAT(WhatOf(report, "certificate dates"), HasSubstr("renew it"));
}

TEST_F(DoctorCommandTest, ARigIsHeldAgainstItsDrive) {
  const Json sound = Doctor(Data());
  const std::string radar = sound["checks"][0]["check"].get<std::string>().substr(
      0, sound["checks"][0]["check"].get<std::string>().find(':'));
  EXPECT_EQ(ResultOf(sound, radar + ": range rates"), "ok");
  // The drive is short: it does not prove that beta is right, and shows that 0 is wrong.
  EXPECT_EQ(ResultOf(sound, radar + ": beta"), "skipped");
  EXPECT_THAT(WhatOf(sound, radar + ": beta"), HasSubstr("does not tell well enough"));
  const Json wrong = Doctor(Data() + " --beta-s 0");
  EXPECT_EQ(ResultOf(wrong, radar + ": beta"), "warning") << WhatOf(wrong, radar + ": beta");
  EXPECT_THAT(WhatOf(wrong, radar + ": beta"), HasSubstr("dcloc calibrate"));

  absl::StatusOr<Drive> drive =
      ReadDrive({DatasetFormat::kNuScenes, Shared("sim"), ""}, {.name = drive_});
  ASSERT_TRUE(drive.ok()) << drive.status();
  for (DriveScan& entry : drive->scans) {
    for (float& rate : entry.scan.range_rate_mps) rate = -rate;
  }
  ASSERT_TRUE(ExportBag(*drive, File("turned.bag"), rosbag::Compression::kLz4).ok());
  const Json turned =
      Doctor("--dataset rosbag --root " + folder_.path().string() + " --drive turned");
  EXPECT_EQ(ResultOf(turned, radar + ": range rates"), "failed");
  EXPECT_EQ(ResultOf(turned, "calibration"), "skipped");
}

}  // namespace
}  // namespace dcloc
