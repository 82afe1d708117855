#include "client/sdk/recording.h"

#include <google/protobuf/stubs/logging.h>

#include <fstream>
#include <iterator>

#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/memory_file.h"
#include "tests/server/fixtures/messages.h"

namespace dcloc {
namespace {

FuzzInput Recording(int scan_count) {
  const MemoryFile file;
  v1::RecordingHeader header;
  header.set_program("fuzz");
  *header.mutable_open() = server::OpenMessage();
  auto writer = client::RecordingWriter::Create(file.path(), header);
  Require(writer.ok(), "a recording begins");
  for (int i = 0; i < scan_count; ++i) {
    v1::RecordedScan scan;
    *scan.mutable_scan() = server::ScanMessage(i, 3);
    writer->Add(scan);
    v1::RecordedFix fix;
    *fix.mutable_fix() = server::FixMessage(i);
    writer->Add(fix);
  }
  Require(writer->Close("done").ok(), "a recording ends");
  std::ifstream in(file.path(), std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace

std::vector<FuzzInput> FuzzSeeds() {
  google::protobuf::SetLogHandler(nullptr);  // it prints a line for each text that is no UTF-8
  return {Recording(3), Recording(0)};
}

}  // namespace dcloc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dcloc::MemoryFile file;
  auto reader = dcloc::client::RecordingReader::Open(file.Write(data, size));
  if (!reader.ok()) return 0;
  for (std::size_t entries = 0;; ++entries) {
    const auto entry = reader->Next();
    if (!entry.ok() || !entry->has_value()) return 0;
    dcloc::Require(entries <= size, "each entry has bytes of the file");
  }
}
