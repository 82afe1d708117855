#include "client/sdk/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <fstream>
#include <iterator>
#include <span>
#include <string>

#include "client/sdk/session.h"
#include "tests/client/sdk/fake_server.h"
#include "tests/core/map/temporary_folder.h"

namespace dcloc::client {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class RecordingTest : public ::testing::Test {
 protected:
  static v1::RecordingHeader Header() {
    v1::RecordingHeader header;
    header.set_program("test 1");
    header.mutable_open()->set_vehicle_id("car");
    header.mutable_open()->set_resume_token("secret-of-open");
    header.mutable_opened()->set_session_id("s1");
    header.mutable_opened()->set_resume_token("secret-of-opened");
    return header;
  }

  static v1::RecordedScan ScanNumber(std::int64_t number) {
    v1::RecordedScan scan;
    scan.mutable_scan()->set_sequence_number(number);
    for (int i = 0; i < 100; ++i) scan.mutable_scan()->add_range_m(static_cast<float>(i));
    scan.mutable_answer()->mutable_result()->set_sequence_number(number);
    return scan;
  }

  std::string Record(int scan_count) const {
    auto writer = *RecordingWriter::Create(file_, Header());
    for (int i = 0; i < scan_count; ++i) writer.Add(ScanNumber(i));
    EXPECT_TRUE(writer.Close("it was over").ok());
    return Text();
  }

  std::string Text() const {
    std::ifstream file(file_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  /// What reading all of the file comes to, if it has these bytes.
  absl::Status StatusOf(const std::string& bytes) const {
    std::ofstream(file_, std::ios::binary | std::ios::trunc) << bytes;
    auto reader = RecordingReader::Open(file_);
    if (!reader.ok()) return reader.status();
    while (true) {
      const auto next = reader->Next();
      if (!next.ok()) return next.status();
      if (!next->has_value()) return absl::OkStatus();
    }
  }

  const TemporaryFolder folder_;
  const std::filesystem::path file_ = folder_.path() / "session.rec";
};

TEST_F(RecordingTest, GivesBackWhatWasRecorded) {
  const std::string bytes = Record(3);
  EXPECT_THAT(bytes, Not(HasSubstr("secret"))) << "tokens are no part of a recording";
  auto reader = *RecordingReader::Open(file_);
  EXPECT_EQ(reader.header().format_version(), kRecordingFormatVersion);
  EXPECT_EQ(reader.header().open().vehicle_id(), "car");
  for (int i = 0; i < 3; ++i) {
    const auto next = reader.Next();
    ASSERT_TRUE(next.ok() && next->has_value());
    EXPECT_EQ((*next)->scan().SerializeAsString(), ScanNumber(i).SerializeAsString());
  }
  EXPECT_FALSE(reader.Next()->has_value());
  EXPECT_EQ(reader.end_reason(), "it was over");
  EXPECT_FALSE(reader.Next()->has_value());
}

TEST_F(RecordingTest, FixesAreInTheirPlaceAndCounted) {
  v1::RecordedFix fix;
  fix.mutable_fix()->set_stamp_ns(7);
  fix.mutable_answer()->set_use(v1::FIX_USE_CONTRADICTED);
  auto writer = *RecordingWriter::Create(file_, Header());
  writer.Add(ScanNumber(0));
  writer.Add(fix);
  writer.Add(ScanNumber(1));
  ASSERT_TRUE(writer.Close("").ok());
  EXPECT_EQ(writer.scan_count(), 2);
  auto reader = *RecordingReader::Open(file_);
  EXPECT_TRUE((*reader.Next())->has_scan());
  EXPECT_EQ((*reader.Next())->fix().SerializeAsString(), fix.SerializeAsString());
  EXPECT_TRUE((*reader.Next())->has_scan());
  EXPECT_FALSE(reader.Next()->has_value());
}

TEST_F(RecordingTest, AFileOfTheFirstFormatIsRead) {
  // Version 1 differs from one without fixes in its number alone, and so in its checksum.
  v1::RecordingHeader header = Header();
  header.set_format_version(1);
  const auto delimited = [](const google::protobuf::MessageLite& message) {
    const std::string text = message.SerializeAsString();
    EXPECT_LT(text.size(), 128U);
    return std::string(1, static_cast<char>(text.size())) + text;
  };
  v1::RecordingEntry scan;
  scan.mutable_scan()->mutable_scan()->set_sequence_number(5);
  std::string bytes = "DCLOCREC" + delimited(header) + delimited(scan);
  v1::RecordingEntry end;
  end.mutable_end()->set_scan_count(1);
  end.mutable_end()->set_crc32(static_cast<std::int64_t>(
      crc32(0, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size()))));
  bytes += delimited(end);
  EXPECT_TRUE(StatusOf(bytes).ok()) << StatusOf(bytes);
}

TEST_F(RecordingTest, EveryTruncationIsNoticed) {
  const std::string bytes = Record(2);
  ASSERT_TRUE(StatusOf(bytes).ok());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const absl::Status status = StatusOf(bytes.substr(0, size));
    ASSERT_FALSE(status.ok()) << size;
    EXPECT_THAT(std::string(status.message()), HasSubstr(file_.string()));
  }
  const absl::Status cut = StatusOf(bytes.substr(0, bytes.size() - 40));
  EXPECT_EQ(cut.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(cut.message()), AllOf(HasSubstr("cut off"), HasSubstr("after 1 scans")));
}

TEST_F(RecordingTest, EveryFlippedBitIsNoticed) {
  const std::string bytes = Record(2);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    EXPECT_FALSE(StatusOf(damaged).ok()) << i;
  }
  EXPECT_EQ(StatusOf(bytes + "x").code(), absl::StatusCode::kDataLoss);
}

TEST_F(RecordingTest, OtherFilesAndNewerFormatsAreRefused) {
  EXPECT_EQ(RecordingReader::Open(folder_.path() / "none").status().code(),
            absl::StatusCode::kNotFound);
  const absl::Status other = StatusOf("DCLOCMAP and more");
  EXPECT_EQ(other.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(other.message()), HasSubstr("no dcloc recording"));
  v1::RecordingHeader header;
  header.set_format_version(kRecordingFormatVersion + 1);
  header.set_program("dcloc-server 9.9");
  const std::string bytes = header.SerializeAsString();
  const absl::Status newer =
      StatusOf("DCLOCREC" + std::string(1, static_cast<char>(bytes.size())) + bytes);
  EXPECT_EQ(newer.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(newer.message()),
              AllOf(HasSubstr("format version 3"), HasSubstr("dcloc-server 9.9")));
  const absl::Status huge = StatusOf("DCLOCREC\xff\xff\xff\xff\x0f");
  EXPECT_EQ(huge.code(), absl::StatusCode::kDataLoss) << "and no memory is taken for it";
}

TEST_F(RecordingTest, AFileThatCannotBeWrittenIsAnError) {
  const absl::Status status =
      RecordingWriter::Create(folder_.path() / "no/such/folder", Header()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("no/such/folder"));
  auto full = RecordingWriter::Create("/dev/full", Header());
  ASSERT_TRUE(full.ok());
  EXPECT_EQ(full->Close("").code(), absl::StatusCode::kResourceExhausted);
}

TEST_F(RecordingTest, ASessionIsRecordedAsItsAnswersAreTaken) {
  const FakeServer server(AnswerAll);
  v1::OpenSession open;
  open.set_vehicle_id("car");
  {
    const auto session = *Session::Open(server.Channel(), open, {.record_file = file_.string()});
    for (int i = 0; i < 5; ++i) {
      v1::Scan scan;
      scan.set_sequence_number(i);
      scan.set_radar_id(i == 3 ? "broken" : "front");
      ASSERT_TRUE(session->Send(scan).ok());
    }
    session->CloseSending();
    while (session->Next()) {
    }
    EXPECT_TRUE(session->record_status().ok()) << session->record_status();
  }
  auto reader = RecordingReader::Open(file_);
  ASSERT_TRUE(reader.ok()) << reader.status();
  EXPECT_EQ(reader->header().opened().session_id(), "session of car");
  for (int i = 0; i < 5; ++i) {
    const auto next = reader->Next();
    ASSERT_TRUE(next.ok() && next->has_value());
    EXPECT_EQ((*next)->scan().scan().sequence_number(), i);
    EXPECT_EQ((*next)->scan().answer().has_rejected(), i == 3);
  }
  const auto end = reader->Next();
  EXPECT_TRUE(end.ok() && !end->has_value()) << end.status();
}

TEST_F(RecordingTest, ASessionThatCannotBeRecordedIsNotOpened) {
  const FakeServer server(AnswerAll);
  v1::OpenSession open;
  open.set_vehicle_id("car");
  const auto session =
      Session::Open(server.Channel(), open, {.record_file = "/no/such/folder/file"});
  EXPECT_EQ(session.status().code(), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace dcloc::client
