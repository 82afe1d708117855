#include "server/objects/s3_xml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace dcloc::server {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

constexpr char kPage[] =
    "<?xml version='1.0' encoding='UTF-8'?>\n"
    "<ListBucketResult xmlns=\"http://s3.amazonaws.com/doc/2006-03-01/\"><Name>b</Name>"
    "<Prefix>maps/</Prefix><KeyCount>2</KeyCount><IsTruncated>true</IsTruncated>"
    "<Contents><Key>maps/a</Key><ETag>\"1\"</ETag><Size>7</Size></Contents>"
    "<Contents><Key>maps/b</Key><Size>0</Size></Contents></ListBucketResult>";

TEST(S3XmlTest, APageHasKeysAndSizes) {
  const auto page = ParseS3Page(kPage);
  ASSERT_TRUE(page.ok()) << page.status();
  EXPECT_THAT(page->objects, ElementsAre(Pair("maps/a", 7), Pair("maps/b", 0)));
  EXPECT_FALSE(page->is_last);
}

TEST(S3XmlTest, WhatIsCutOffOrSomethingElseIsNoPage) {
  const std::string page = kPage;
  for (std::size_t size = 0; size < page.size(); ++size) {
    EXPECT_TRUE(absl::IsDataLoss(ParseS3Page(page.substr(0, size)).status())) << size;
  }
  EXPECT_FALSE(ParseS3Page("<html>maintenance</html>").ok());
  std::string wrong = page;
  wrong.replace(wrong.find("<Size>7"), 7, "<Size>-");
  EXPECT_FALSE(ParseS3Page(wrong).ok());
}

TEST(S3XmlTest, AnErrorHasACodeThatMayStandInALog) {
  EXPECT_EQ(S3ErrorCode("<?xml?><Error><Code>NoSuchKey</Code><Message>x</Message></Error>"),
            "NoSuchKey");
  EXPECT_EQ(S3ErrorCode("<Error><Code>a\nb\"c</Code></Error>"), "abc");
  EXPECT_EQ(S3ErrorCode("<CopyObjectResult/>"), "");
  EXPECT_EQ(S3ErrorCode(""), "");
}

}  // namespace
}  // namespace dcloc::server
