#include "client/cli/localize/answer_files.h"

#include <cerrno>
#include <cstdint>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/evaluation/metrics_format.h"
#include "client/trajectory/trajectory_writer.h"

namespace dcloc::cli {
namespace {

std::string CsvHeader() {
  std::string header = "stamp_ns,radar,state,x,y,z,qx,qy,qz,qw";
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 6; ++column) absl::StrAppend(&header, ",c", row, column);
  }
  return header + ",latency_ms,map_version\n";
}

// Position and quaternion, each after a separator.
void AppendPose(std::string& line, const v1::Pose& pose, char separator) {
  const v1::Vector3& t = pose.translation_m();
  const v1::Quaternion& q = pose.rotation();
  for (const double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}) {
    absl::StrAppendFormat(&line, "%c%.17g", separator, value);
  }
}

std::string CsvLine(const v1::LocalizationResult& result, const ScanOutcome& outcome) {
  std::string line = absl::StrFormat("%d,%s,%s", result.stamp_ns(), outcome.radar_id,
                                     StateName(outcome.answer.state));
  AppendPose(line, result.pose().pose(), ',');
  for (const double value : result.pose().covariance()) {
    absl::StrAppendFormat(&line, ",%.17g", value);
  }
  absl::StrAppendFormat(&line, ",%.3f,%d\n", outcome.total_ms, result.map_version());
  return line;
}

}  // namespace

absl::Status AnswerFiles::Open(const std::string& path, File& file) {
  file.path = path;
  file.stream.open(path, std::ios::binary | std::ios::trunc);
  return file.stream ? absl::OkStatus() : absl::ErrnoToStatus(errno, path);
}

absl::Status AnswerFiles::Close(File& file) {
  if (!file.stream.is_open()) return absl::OkStatus();
  file.stream.close();
  return file.stream ? absl::OkStatus()
                     : absl::DataLossError(absl::StrCat(file.path, ": could not be written"));
}

absl::StatusOr<AnswerFiles> AnswerFiles::Create(const std::string& csv_path,
                                                const std::string& tum_path) {
  AnswerFiles files;
  absl::Status status = Open(csv_path, files.csv_);
  if (!tum_path.empty()) status.Update(Open(tum_path, files.tum_));
  if (!status.ok()) return status;
  files.csv_.stream << CsvHeader();
  return files;
}

void AnswerFiles::Add(const v1::LocalizationResult& result, const ScanOutcome& outcome) {
  csv_.stream << CsvLine(result, outcome);
  if (tum_.stream.is_open() && outcome.answered()) {
    tum_.stream << TumLine({outcome.answer.stamp, outcome.answer.T_map_vehicle});
  }
}

absl::Status AnswerFiles::Close() {
  absl::Status status = Close(csv_);
  status.Update(Close(tum_));
  return status;
}

}  // namespace dcloc::cli
