#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/common/dataset_options.h"
#include "client/datasets/drive.h"
#include "client/datasets/drive_request.h"
#include "core/mapping/drive_source.h"

namespace dcloc::cli {

/// The drives that a command names, each read whole when it is opened.
class DatasetDrives final : public DriveSource {
 public:
  /// All of `request` but its name. What is referred to outlives it. `on_open`, where given, sees
  /// each drive as it is read.
  DatasetDrives(const DatasetArguments& dataset, const DriveRequest& request,
                const std::vector<std::string>& names,
                std::function<void(std::size_t, const Drive&)> on_open = {})
      : dataset_(dataset), request_(request), names_(names), on_open_(std::move(on_open)) {}

  std::size_t drive_count() const override { return names_.size(); }
  absl::StatusOr<std::unique_ptr<DriveReader>> Open(std::size_t drive) override;

 private:
  const DatasetArguments& dataset_;
  const DriveRequest& request_;
  const std::vector<std::string>& names_;
  const std::function<void(std::size_t, const Drive&)> on_open_;
};

}  // namespace dcloc::cli
