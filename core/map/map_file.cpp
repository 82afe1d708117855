#include "core/map/map_file.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <limits>

#include "absl/strings/str_format.h"
#include "core/map/data_loss.h"
#include "core/map/map_content.h"

namespace dcloc {
namespace {

const MapFileHeader& HeaderOf(std::span<const std::byte> bytes) {
  return *reinterpret_cast<const MapFileHeader*>(bytes.data());
}

absl::Status CheckHeader(const MapFileHeader& header, std::span<const std::byte> bytes) {
  if (header.magic != kMapFileMagic) return DataLoss("not a map file: the magic bytes differ");
  if (header.version != kMapFileVersion) {
    return DataLoss("format version is %d; only %d can be read", header.version, kMapFileVersion);
  }
  const std::uint32_t crc32 = Crc32(bytes.first(offsetof(MapFileHeader, crc32)));
  if (header.crc32 != crc32) {
    return DataLoss("header: checksum is %08x; its bytes give %08x", header.crc32, crc32);
  }
  if (header.section_count != kMapSectionCount) {
    return DataLoss("header: section_count is %d; it must be %d", header.section_count,
                    kMapSectionCount);
  }
  if (header.file_size_bytes != bytes.size()) {
    return DataLoss("header: file_size_bytes is %d; the file has %d", header.file_size_bytes,
                    bytes.size());
  }
  return absl::OkStatus();
}

// Sections lie in order, each at the next multiple of the alignment, and the last ends the file:
// one layout for one content, so nothing can hide between them.
absl::Status CheckSections(const MapFileHeader& header) {
  std::uint64_t end_bytes = sizeof(MapFileHeader);
  for (std::size_t i = 0; i < kMapSectionCount; ++i) {
    const SectionEntry& section = header.sections[i];
    if (section.offset_bytes != AlignSection(end_bytes) ||
        section.offset_bytes > header.file_size_bytes ||
        section.size_bytes > header.file_size_bytes - section.offset_bytes) {
      return DataLoss("section %s: %d bytes at %d; it must begin at %d and end by %d",
                      kMapSectionNames[i], section.size_bytes, section.offset_bytes,
                      AlignSection(end_bytes), header.file_size_bytes);
    }
    end_bytes = section.offset_bytes + section.size_bytes;
  }
  if (end_bytes == header.file_size_bytes) return absl::OkStatus();
  return DataLoss("the sections end at %d; the file at %d", end_bytes, header.file_size_bytes);
}

// Only for bytes whose header and sections have been checked.
std::span<const std::byte> SectionBytes(std::span<const std::byte> bytes, MapSection section) {
  const SectionEntry& entry = HeaderOf(bytes).sections[static_cast<std::size_t>(section)];
  return bytes.subspan(entry.offset_bytes, entry.size_bytes);
}

absl::Status CheckSectionCrc32(std::span<const std::byte> bytes, MapSection section) {
  const auto i = static_cast<std::size_t>(section);
  const std::uint32_t expected = HeaderOf(bytes).sections[i].crc32;
  const std::uint32_t crc32 = Crc32(SectionBytes(bytes, section));
  if (crc32 == expected) return absl::OkStatus();
  return DataLoss("section %s: checksum is %08x; its bytes give %08x", kMapSectionNames[i],
                  expected, crc32);
}

template <typename Record>
absl::Status ReadRecords(std::span<const std::byte> bytes, MapSection section,
                         std::span<const Record>& records) {
  const std::span<const std::byte> part = SectionBytes(bytes, section);
  const std::size_t count = part.size() / sizeof(Record);
  if (part.size() % sizeof(Record) != 0 || count > std::numeric_limits<std::uint32_t>::max()) {
    return DataLoss("section %s: %d bytes; it must be records of %d bytes, fewer than 2^32",
                    kMapSectionNames[static_cast<std::size_t>(section)], part.size(),
                    sizeof(Record));
  }
  records = {reinterpret_cast<const Record*>(part.data()), count};
  return absl::OkStatus();
}

absl::Status ReadInfo(std::span<const std::byte> bytes, MapFileView& view) {
  std::span<const InfoRecord> records;
  absl::Status status = ReadRecords(bytes, MapSection::kInfo, records);
  if (!status.ok()) return status;
  if (records.size() != 1) return DataLoss("section info: %d records, not 1", records.size());
  view.info = records.front();
  return absl::OkStatus();
}

absl::Status ReadText(std::span<const std::byte> bytes, MapFileView& view) {
  const std::span<const std::byte> part = SectionBytes(bytes, MapSection::kText);
  const std::string_view text(reinterpret_cast<const char*>(part.data()), part.size());
  if (view.info.name_size_bytes > text.size()) {
    return DataLoss("info: name_size_bytes is %d; the text has %d", view.info.name_size_bytes,
                    text.size());
  }
  view.name = text.substr(0, view.info.name_size_bytes);
  view.description = text.substr(view.info.name_size_bytes);
  return absl::OkStatus();
}

bool AllZero(std::span<const std::byte> bytes) {
  return std::ranges::all_of(bytes, [](std::byte byte) { return byte == std::byte{0}; });
}

absl::Status CheckGaps(std::span<const std::byte> bytes) {
  const MapFileHeader& header = HeaderOf(bytes);
  bool zero = AllZero(std::as_bytes(std::span(header.zero)));
  std::uint64_t end_bytes = sizeof(MapFileHeader);
  for (const SectionEntry& section : header.sections) {
    zero = zero && section.zero == 0 &&
           AllZero(bytes.subspan(end_bytes, section.offset_bytes - end_bytes));
    end_bytes = section.offset_bytes + section.size_bytes;
  }
  return zero ? absl::OkStatus() : DataLoss("bytes between the sections are not zero");
}

}  // namespace

std::uint32_t Crc32(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

absl::StatusOr<MapFileView> ParseMapFile(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof(MapFileHeader)) {
    return DataLoss("the file has %d bytes; its header alone has %d", bytes.size(),
                    sizeof(MapFileHeader));
  }
  MapFileView view{};
  absl::Status status = CheckHeader(HeaderOf(bytes), bytes);
  if (status.ok()) status = CheckSections(HeaderOf(bytes));
  for (const MapSection section :
       {MapSection::kInfo, MapSection::kText, MapSection::kKeyframes, MapSection::kIndex}) {
    if (status.ok()) status = CheckSectionCrc32(bytes, section);
  }
  if (status.ok()) status = ReadInfo(bytes, view);
  if (status.ok()) status = ReadText(bytes, view);
  if (status.ok()) status = ReadRecords(bytes, MapSection::kKeyframes, view.keyframes);
  if (status.ok()) status = ReadRecords(bytes, MapSection::kIndex, view.index);
  if (status.ok()) status = ReadRecords(bytes, MapSection::kPoints, view.points);
  if (status.ok()) status = CheckContent(view);
  if (!status.ok()) return status;
  return view;
}

absl::Status VerifyMapFile(std::span<const std::byte> bytes, const MapFileView& view) {
  absl::Status status = CheckGaps(bytes);
  for (const MapSection section : {MapSection::kInfo, MapSection::kText, MapSection::kKeyframes,
                                   MapSection::kIndex, MapSection::kPoints}) {
    // Once more for those that were checked when opened: the disk may have changed its mind.
    if (status.ok()) status = CheckSectionCrc32(bytes, section);
  }
  if (status.ok()) status = CheckPoints(view.points);
  return status;
}

std::vector<std::byte> WriteMapFile(const MapFileView& view) {
  const std::string text = std::string(view.name).append(view.description);
  const std::array<std::span<const std::byte>, kMapSectionCount> parts = {
      std::as_bytes(std::span(&view.info, 1)), std::as_bytes(std::span(text)),
      std::as_bytes(view.keyframes), std::as_bytes(view.index), std::as_bytes(view.points)};

  MapFileHeader header{};
  header.magic = kMapFileMagic;
  header.version = kMapFileVersion;
  header.section_count = kMapSectionCount;
  header.file_size_bytes = sizeof(MapFileHeader);
  for (std::size_t i = 0; i < kMapSectionCount; ++i) {
    const std::uint64_t offset_bytes = AlignSection(header.file_size_bytes);
    header.sections[i] = {offset_bytes, parts[i].size(), Crc32(parts[i]), 0};
    header.file_size_bytes = offset_bytes + parts[i].size();
  }
  header.crc32 = Crc32(std::as_bytes(std::span(&header, 1)).first(offsetof(MapFileHeader, crc32)));

  std::vector<std::byte> bytes(header.file_size_bytes);
  std::memcpy(bytes.data(), &header, sizeof(header));
  for (std::size_t i = 0; i < kMapSectionCount; ++i) {
    std::ranges::copy(parts[i],
                      bytes.begin() + static_cast<std::ptrdiff_t>(header.sections[i].offset_bytes));
  }
  return bytes;
}

}  // namespace dcloc
