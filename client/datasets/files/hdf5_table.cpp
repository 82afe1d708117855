#include "client/datasets/files/hdf5_table.h"

#include <hdf5.h>

#include <utility>

#include "absl/strings/str_cat.h"
#include "client/datasets/files/file_error.h"

namespace dcloc {
namespace {

// Ten times the largest recording that is published; a file that claims more is broken.
constexpr hssize_t kMaxRows = 50'000'000;

/// Owns an HDF5 identifier.
class Id {
 public:
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Id(const Id&) = delete;
  Id& operator=(const Id&) = delete;
  ~Id() {
    if (valid()) close_(id_);
  }
  bool valid() const { return id_ >= 0; }
  hid_t get() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// HDF5 prints its errors to stderr unless told not to; ours go into a status.
class QuietErrors {
 public:
  QuietErrors() {
    H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;
  ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, print_, print_data_); }

  // What HDF5 found wrong last, in its own words: the innermost description.
  static std::string Reason() {
    std::string reason;
    const auto visit = [](unsigned /*depth*/, const H5E_error2_t* error, void* out) -> herr_t {
      if (error->desc != nullptr) *static_cast<std::string*>(out) = error->desc;
      return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, visit, &reason);
    return reason;
  }

 private:
  H5E_auto2_t print_ = nullptr;
  void* print_data_ = nullptr;
};

hid_t MemoryType(Hdf5Column::Type type) {
  return type == Hdf5Column::Type::kInt64 ? H5T_NATIVE_INT64 : H5T_NATIVE_FLOAT;
}

absl::Status CheckColumn(hid_t file_type, const Hdf5Column& column) {
  const int index = H5Tget_member_index(file_type, column.name);
  if (index < 0) return absl::DataLossError(absl::StrCat("has no column \"", column.name, "\""));
  const bool wants_integer = column.type == Hdf5Column::Type::kInt64;
  const H5T_class_t found = H5Tget_member_class(file_type, static_cast<unsigned>(index));
  if (found != (wants_integer ? H5T_INTEGER : H5T_FLOAT)) {
    return absl::DataLossError(absl::StrCat("column \"", column.name, "\" must hold ",
                                            wants_integer ? "integers" : "floating-point numbers"));
  }
  return absl::OkStatus();
}

absl::Status CheckTable(hid_t file_type, std::span<const Hdf5Column> columns) {
  if (H5Tget_class(file_type) != H5T_COMPOUND) {
    return absl::DataLossError("is not a table with named columns");
  }
  for (const Hdf5Column& column : columns) {
    if (absl::Status status = CheckColumn(file_type, column); !status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::size_t> RowCount(hid_t dataset) {
  const Id space(H5Dget_space(dataset), H5Sclose);
  const hssize_t count = space.valid() ? H5Sget_simple_extent_npoints(space.get()) : -1;
  if (count < 0 || count > kMaxRows) {
    return absl::DataLossError(absl::StrCat("must have [0, ", kMaxRows, "] rows, it has ", count));
  }
  return static_cast<std::size_t>(count);
}

absl::Status ReadRows(hid_t dataset, std::span<const Hdf5Column> columns, std::size_t row_bytes,
                      Hdf5Rows& rows) {
  const Id file_type(H5Dget_type(dataset), H5Tclose);
  if (absl::Status status = CheckTable(file_type.get(), columns); !status.ok()) return status;
  const auto row_count = RowCount(dataset);
  if (!row_count.ok()) return row_count.status();
  const Id row_type(H5Tcreate(H5T_COMPOUND, row_bytes), H5Tclose);
  for (const Hdf5Column& column : columns) {
    H5Tinsert(row_type.get(), column.name, column.offset_bytes, MemoryType(column.type));
  }
  void* data = rows.Resize(*row_count);
  if (*row_count > 0 && H5Dread(dataset, row_type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0) {
    return absl::DataLossError(absl::StrCat("cannot be read: ", QuietErrors::Reason()));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ReadHdf5Columns(const std::filesystem::path& path, const std::string& dataset,
                             std::span<const Hdf5Column> columns, std::size_t row_bytes,
                             Hdf5Rows& rows) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return CannotOpen(path);
  const QuietErrors quiet;
  const Id file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.valid()) {
    return FileError(path, absl::StrCat("is no readable HDF5 file: ", QuietErrors::Reason()));
  }
  const Id table(H5Dopen2(file.get(), dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (!table.valid()) return FileError(path, absl::StrCat("has no data set \"", dataset, "\""));
  const absl::Status status = ReadRows(table.get(), columns, row_bytes, rows);
  if (!status.ok()) {
    return FileError(path, absl::StrCat("data set \"", dataset, "\" ", status.message()));
  }
  return absl::OkStatus();
}

}  // namespace dcloc
