#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

#include "dcloc/v1/pass_service.grpc.pb.h"
#include "server/app/storage.h"
#include "tests/server/fixtures/test_server.h"
#include "tests/server/fixtures/town_drive.h"

// Passes of vehicles that drive through a server.
namespace dcloc::server {
namespace {

using ::testing::HasSubstr;

class PassServiceTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { drive_ = std::make_unique<TownDrive>(); }
  static void TearDownTestSuite() { drive_.reset(); }

  void Start(ServerConfig config = {}) {
    server_ = std::make_unique<TestServer>(std::move(config));
    passes_ = v1::PassService::NewStub(server_->channel);
    v1::UploadMapResponse response;
    ASSERT_TRUE(UploadMap(*server_->maps, HeaderOf(drive_->map), drive_->map, &response).ok());
  }

  grpc::Status Set(const v1::PassConsent& consent, v1::PassConsentState state,
                   int* removed_count = nullptr) {
    Call call;
    v1::SetPassConsentRequest request;
    *request.mutable_consent() = consent;
    request.set_state(state);
    v1::SetPassConsentResponse response;
    grpc::Status status = passes_->SetPassConsent(&call, request, &response);
    if (removed_count != nullptr) *removed_count = response.removed_pass_count();
    return status;
  }

  static v1::PassConsent OfMap(const std::string& name) {
    v1::PassConsent consent;
    consent.set_map_name(name);
    return consent;
  }
  static v1::PassConsent OfIdentity(const std::string& name) {
    v1::PassConsent consent;
    consent.set_identity_name(name);
    return consent;
  }

  void Drive(const std::string& vehicle_id = "car-1") {
    TestSession session(*server_->localization);
    v1::OpenSession open = drive_->Open();
    open.set_vehicle_id(vehicle_id);
    ASSERT_TRUE(session.Open(open));
    ASSERT_TRUE(session.Read().has_value());
    v1::LocalizationResult last;
    for (const v1::Scan& scan : drive_->Scans()) last = session.Localize(scan)->result();
    EXPECT_EQ(last.state(), v1::LOCALIZATION_STATE_TRACKING);
    session.CloseSending();
    EXPECT_TRUE(session.Finish().ok());
  }

  v1::ListPassesResponse List(int page_size = 0, const std::string& page_token = "") {
    Call call;
    v1::ListPassesRequest request;
    request.set_map_name("town");
    request.set_page_size(page_size);
    request.set_page_token(page_token);
    v1::ListPassesResponse response;
    EXPECT_TRUE(passes_->ListPasses(&call, request, &response).ok());
    return response;
  }

  std::size_t FileCount() const {
    std::size_t count = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(server_->folder.path() / "store" / "passes")) {
      count += entry.is_regular_file() ? 1U : 0U;
    }
    return count;
  }

  static inline std::unique_ptr<TownDrive> drive_;
  std::unique_ptr<TestServer> server_;
  std::unique_ptr<v1::PassService::Stub> passes_;
};

TEST_F(PassServiceTest, WithoutBothConsentsNothingIsKept) {
  Start();
  Drive();
  ASSERT_TRUE(Set(OfMap("town"), v1::PASS_CONSENT_STATE_GIVEN).ok());
  Drive();
  ASSERT_TRUE(Set(OfMap("town"), v1::PASS_CONSENT_STATE_WITHDRAWN).ok());
  ASSERT_TRUE(Set(OfIdentity("anonymous"), v1::PASS_CONSENT_STATE_GIVEN).ok());
  Drive();
  server_->server.reset();
  EXPECT_EQ(FileCount(), 0U);
}

TEST_F(PassServiceTest, WithBothWhatWasTrackedIsKeptUntilOneIsWithdrawn) {
  Start();
  ASSERT_TRUE(Set(OfMap("town"), v1::PASS_CONSENT_STATE_GIVEN).ok());
  ASSERT_TRUE(Set(OfIdentity("anonymous"), v1::PASS_CONSENT_STATE_GIVEN).ok());
  Drive("car-1");
  Drive("car-2");
  Drive("car-1");
  ASSERT_TRUE(Eventually([&] { return List().passes_size() == 3; }));
  const v1::ListPassesResponse all = List();
  EXPECT_EQ(all.passes(0).vehicle_pseudonym(), all.passes(2).vehicle_pseudonym());
  EXPECT_NE(all.passes(0).vehicle_pseudonym(), all.passes(1).vehicle_pseudonym());
  EXPECT_GT(all.passes(0).scan_count(), 100);
  EXPECT_EQ(all.passes(0).map_version(), 1);
  EXPECT_EQ(all.passes(0).expire_time().seconds() - all.passes(0).create_time().seconds(),
            30 * 86'400);
  const v1::ListPassesResponse page = List(2);
  EXPECT_EQ(page.passes_size(), 2);
  EXPECT_EQ(List(2, page.next_page_token()).passes_size(), 1);
  EXPECT_EQ(FileCount(), 3U);
  int removed_count = 0;
  ASSERT_TRUE(Set(OfIdentity("anonymous"), v1::PASS_CONSENT_STATE_WITHDRAWN, &removed_count).ok());
  EXPECT_EQ(removed_count, 3);
  EXPECT_EQ(List().passes_size(), 0);
  EXPECT_EQ(FileCount(), 0U);
}

TEST_F(PassServiceTest, WhatIsOverTheQuotaIsNotKept) {
  ServerConfig config;
  config.pass_vehicle_mib_per_day = 0;
  Start(config);
  ASSERT_TRUE(Set(OfMap("town"), v1::PASS_CONSENT_STATE_GIVEN).ok());
  ASSERT_TRUE(Set(OfIdentity("anonymous"), v1::PASS_CONSENT_STATE_GIVEN).ok());
  Drive();
  server_->server.reset();
  EXPECT_EQ(FileCount(), 0U);
}

TEST_F(PassServiceTest, AMapThatIsDeletedTakesItsConsentAlong) {
  Start(TestServer::StubConfig());
  ASSERT_TRUE(Set(OfMap("town"), v1::PASS_CONSENT_STATE_GIVEN).ok());
  Call call;
  v1::DeleteMapRequest request;
  request.set_map_name("town");
  v1::DeleteMapResponse response;
  ASSERT_TRUE(server_->maps->DeleteMap(&call, request, &response).ok());
  Call again;
  v1::ListPassConsentsResponse consents;
  ASSERT_TRUE(passes_->ListPassConsents(&again, {}, &consents).ok());
  EXPECT_EQ(consents.consents_size(), 0);
}

TEST_F(PassServiceTest, FaultsAreNamedAndWhoMayIsSaid) {
  Start(TestServer::StubConfig());
  const auto expect = [&](const std::string& part, const v1::PassConsent& consent,
                          v1::PassConsentState state) {
    const grpc::Status status = Set(consent, state);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT) << part;
    EXPECT_THAT(status.error_message(), HasSubstr(part));
  };
  expect("consent.subject is missing", {}, v1::PASS_CONSENT_STATE_GIVEN);
  expect("consent.map_name", OfMap("A b"), v1::PASS_CONSENT_STATE_GIVEN);
  expect("consent.identity_name", OfIdentity(""), v1::PASS_CONSENT_STATE_GIVEN);
  expect("state is 0", OfMap("town"), v1::PASS_CONSENT_STATE_UNSPECIFIED);
  const auto identities = *OpenIdentities(server_->folder.path() / "store");
  const std::string vehicle =
      *identities->Create(Proof::kToken, {.name = "car-1", .role = Role::kVehicle}, {});
  const std::string other = *identities->Create(
      Proof::kToken, {.name = "ops", .tenant = "other", .role = Role::kOperator}, {});
  v1::SetPassConsentRequest request;
  *request.mutable_consent() = OfIdentity("car-1");
  request.set_state(v1::PASS_CONSENT_STATE_GIVEN);
  v1::SetPassConsentResponse response;
  CallAs by_vehicle(vehicle);
  EXPECT_EQ(passes_->SetPassConsent(&by_vehicle, request, &response).error_code(),
            grpc::StatusCode::PERMISSION_DENIED);
  CallAs by_other(other);
  EXPECT_TRUE(passes_->SetPassConsent(&by_other, request, &response).ok());
  const std::string own =
      *identities->Create(Proof::kToken, {.name = "own", .role = Role::kOperator}, {});
  CallAs by_own(own);
  v1::ListPassConsentsResponse consents;
  ASSERT_TRUE(passes_->ListPassConsents(&by_own, {}, &consents).ok());
  EXPECT_EQ(consents.consents_size(), 0) << "another tenant's are not seen";
}

}  // namespace
}  // namespace dcloc::server
