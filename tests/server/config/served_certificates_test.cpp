#include "server/config/served_certificates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/core/map/temporary_folder.h"
#include "tests/server/fixtures/test_certificates.h"

namespace dcloc::server {
namespace {

using std::chrono::hours;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class ServedCertificatesTest : public ::testing::Test {
 protected:
  ServedCertificatesTest()
      : authority_(TestCertificate::Authority("fleet authority")),
        first_(TestCertificate::SignedBy(authority_, "first")),
        second_(TestCertificate::SignedBy(authority_, "second")) {
    config_.tls_cert = folder_.path() / "served.pem";
    config_.tls_key = folder_.path() / "served.key";
    first_.Write(folder_.path(), "served");
    served_ = *ServedCertificates::Load(config_, now_);
  }

  void Write(const std::string& path, const std::string& content) const {
    std::ofstream(path) << content;
  }

  /// The files are judged at the second look.
  void Refresh() {
    served_->Refresh(now_);
    served_->Refresh(now_);
  }

  std::string FaultOf(const std::string& chain, const std::string& key) {
    Write(config_.tls_cert, chain);
    Write(config_.tls_key, key);
    Refresh();
    EXPECT_EQ(served_->files()->chain, first_.CertificatePem()) << "the good ones stay";
    return served_->state().fault;
  }

  const SystemTime now_ = std::chrono::system_clock::now();
  TemporaryFolder folder_;
  ServerConfig config_;
  TestCertificate authority_;
  TestCertificate first_;
  TestCertificate second_;
  std::shared_ptr<ServedCertificates> served_;
};

TEST_F(ServedCertificatesTest, GoodOnesAreTakenAtTheSecondLook) {
  EXPECT_GT(served_->state().expire_time, now_ + hours(23));
  second_.Write(folder_.path(), "served");
  served_->Refresh(now_);
  EXPECT_EQ(served_->files()->chain, first_.CertificatePem()) << "it may be half of a change";
  served_->Refresh(now_);
  EXPECT_EQ(served_->files()->chain, second_.CertificatePem());
  EXPECT_THAT(served_->state().fault, IsEmpty());
}

TEST_F(ServedCertificatesTest, BadOnesAreNotShownButTold) {
  const std::string chain = second_.CertificatePem();
  const std::string key = second_.KeyPem();
  EXPECT_THAT(FaultOf("", key), HasSubstr("tls_cert"));
  EXPECT_THAT(FaultOf("garbage", key), HasSubstr("tls_cert"));
  EXPECT_THAT(FaultOf(chain.substr(0, chain.size() / 2), key), HasSubstr("tls_cert"));
  EXPECT_THAT(FaultOf(chain, ""), HasSubstr("tls_key"));
  EXPECT_THAT(FaultOf(chain, key.substr(0, key.size() / 2)), HasSubstr("tls_key"));
  EXPECT_THAT(FaultOf(chain, authority_.KeyPem()), HasSubstr("not the key of tls_cert"));
  EXPECT_THAT(FaultOf(chain + first_.CertificatePem(), key),
              HasSubstr("certificate 1 is not signed by certificate 2"));
  std::filesystem::remove(config_.tls_key);
  Refresh();
  EXPECT_THAT(served_->state().fault, AllOf(HasSubstr("tls_key"), HasSubstr("served.key")));
  first_.Write(folder_.path(), "served");
  Refresh();
  EXPECT_THAT(served_->state().fault, IsEmpty()) << "the files have again what is shown";
}

TEST_F(ServedCertificatesTest, AChainIsTaken) {
  Write(config_.tls_cert, second_.CertificatePem() + authority_.CertificatePem());
  Write(config_.tls_key, second_.KeyPem());
  Refresh();
  EXPECT_THAT(served_->state().fault, IsEmpty());
}

TEST_F(ServedCertificatesTest, DatesCount) {
  const auto expired = TestCertificate::ValidFor(authority_, "old", -2, -1);
  EXPECT_THAT(FaultOf(expired.CertificatePem(), expired.KeyPem()), HasSubstr("expired at"));
  const auto early = TestCertificate::ValidFor(authority_, "new", 1, 2);
  EXPECT_THAT(FaultOf(early.CertificatePem(), early.KeyPem()), HasSubstr("not valid before"));
  served_->Refresh(now_ + hours(25));
  EXPECT_EQ(served_->files()->chain, early.CertificatePem()) << "its time has come";
}

TEST_F(ServedCertificatesTest, AnAuthorityIsCheckedToo) {
  config_.tls_client_ca = folder_.path() / "authority.pem";
  Write(config_.tls_client_ca, "");
  EXPECT_THAT(std::string(ServedCertificates::Load(config_, now_).status().message()),
              HasSubstr("tls_client_ca"));
  Write(config_.tls_client_ca, authority_.CertificatePem());
  EXPECT_TRUE(ServedCertificates::Load(config_, now_).ok());
}

}  // namespace
}  // namespace dcloc::server
