#include "client/datasets/files/json_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/client/datasets/temp_folder.h"

namespace dcloc {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

absl::Status Ignore(TableRecord& /*record*/) { return absl::OkStatus(); }

TEST(ReadTable, GivesEachRecordItsOwnFields) {
  const TempFolder folder;
  const auto path = folder.Write("table.json", R"([
    {"token": "a", "time": 1532402927664178, "at": [1, 2.5, -3e1], "extra": {"token": [1, [2]]}},
    {"at": [4, 5, 6], "nested": [[1, 0], [0, 1]], "token": "b", "time": -1, "on": true, "no": null}
  ])");
  std::vector<std::string> tokens;
  std::vector<std::int64_t> times;
  std::vector<double> at;
  const absl::Status status = ReadTable(path, [&](TableRecord& record) {
    tokens.emplace_back(record.Text("token"));
    times.push_back(record.Integer("time"));
    for (const double value : record.Numbers<3>("at")) at.push_back(value);
    return absl::OkStatus();
  });
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_THAT(tokens, ElementsAre("a", "b"));
  EXPECT_THAT(times, ElementsAre(1532402927664178, -1));
  EXPECT_THAT(at, ElementsAre(1.0, 2.5, -30.0, 4.0, 5.0, 6.0));
}

TEST(ReadTable, NamesFileRecordAndField) {
  const TempFolder folder;
  const auto path = folder.Write("table.json", R"([{"token": "a"}, {"token": 7}])");
  const absl::Status status = ReadTable(path, [](TableRecord& record) {
    record.Text("token");
    return absl::OkStatus();
  });
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss);
  EXPECT_THAT(std::string(status.message()), AllOf(HasSubstr(path.string()), HasSubstr("record 1"),
                                                   HasSubstr("\"token\" must be a string")));
}

TEST(ReadTable, RefusesFieldsOfAnotherType) {
  const TempFolder folder;
  const auto path = folder.Write(
      "table.json",
      R"([{"half": 0.5, "huge": 18446744073709551615, "two": [1, 2], "mix": [1, "2"]}])");
  const auto message = [&](auto read) {
    const absl::Status status = ReadTable(path, [&](TableRecord& record) {
      read(record);
      return absl::OkStatus();
    });
    return std::string(status.message());
  };
  EXPECT_THAT(message([](TableRecord& r) { r.Integer("half"); }), HasSubstr("must be an integer"));
  EXPECT_THAT(message([](TableRecord& r) { r.Integer("huge"); }), HasSubstr("must be an integer"));
  EXPECT_THAT(message([](TableRecord& r) { r.Integer("none"); }), HasSubstr("\"none\" is missing"));
  EXPECT_THAT(message([](TableRecord& r) { r.Numbers<3>("two"); }),
              HasSubstr("has 2 numbers; it must have 3"));
  EXPECT_THAT(message([](TableRecord& r) { r.Numbers<2>("mix"); }),
              HasSubstr("must be an array of numbers"));
}

TEST(ReadTable, StopsAtTheVisitorsError) {
  const TempFolder folder;
  const auto path = folder.Write("table.json", R"([{"a": 1}, {"a": 2}, {"a": 3}])");
  int visited = 0;
  const absl::Status status = ReadTable(path, [&](TableRecord& record) {
    ++visited;
    return record.Integer("a") == 2 ? absl::DataLossError("two is wrong") : absl::OkStatus();
  });
  EXPECT_EQ(visited, 2);
  EXPECT_THAT(std::string(status.message()), HasSubstr("record 1: two is wrong"));
}

TEST(ReadTable, RefusesWhatIsNoTable) {
  const TempFolder folder;
  for (const char* text :
       {"", "{", "[{\"a\": 1}", "[{\"a\": }]", "[{\"a\": 1}] x", "{\"a\": 1}", "7", "[1, 2]",
        "[[1]]", "\"text\"", "[\"text\"]", "[null]", "\xff\xfe"}) {
    const auto path = folder.Write("table.json", text);
    const absl::Status status = ReadTable(path, Ignore);
    EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << text;
    EXPECT_THAT(std::string(status.message()), HasSubstr(path.string())) << text;
  }
}

TEST(ReadTable, AcceptsAnEmptyTable) {
  const TempFolder folder;
  EXPECT_TRUE(ReadTable(folder.Write("table.json", "[]"), Ignore).ok());
}

TEST(ReadTable, SaysThatAFileIsNotThere) {
  const TempFolder folder;
  const absl::Status status = ReadTable(folder.path() / "none.json", Ignore);
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(status.message()), HasSubstr("none.json"));
}

}  // namespace
}  // namespace dcloc
