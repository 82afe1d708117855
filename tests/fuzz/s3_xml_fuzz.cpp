#include "server/objects/s3_xml.h"

#include <string>

#include "tests/fuzz/fuzz_target.h"

namespace dcloc {

std::vector<FuzzInput> FuzzSeeds() {
  const std::string page =
      "<?xml version='1.0' encoding='UTF-8'?>\n"
      "<ListBucketResult xmlns=\"http://s3.amazonaws.com/doc/2006-03-01/\">"
      "<Name>b</Name><Prefix>maps/</Prefix><KeyCount>2</KeyCount><IsTruncated>true</IsTruncated>"
      "<Contents><Key>maps/a&amp;b</Key><ETag>\"1\"</ETag><Size>7</Size></Contents>"
      "<Contents><Key>maps/b</Key><Size>0</Size></Contents></ListBucketResult>";
  const std::string error = "<?xml?><Error><Code>NoSuchKey</Code><Message>x</Message></Error>";
  Require(server::ParseS3Page(page).ok() && server::S3ErrorCode(error) == "NoSuchKey",
          "the seeds are valid");
  return {InputOf(page), InputOf(error),
          InputOf("<ListBucketResult><IsTruncated>false</IsTruncated></ListBucketResult>")};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const absl::string_view xml(reinterpret_cast<const char*>(data), size);
  if (const auto page = dcloc::server::ParseS3Page(xml); page.ok()) {
    for (const auto& [key, bytes] : page->objects) {
      dcloc::Require(bytes >= 0, "no object has a negative size");
    }
  }
  for (const char letter : dcloc::server::S3ErrorCode(xml)) {
    dcloc::Require(letter > ' ' && letter < '\x7f', "a code may stand in a log");
  }
  return 0;
}
