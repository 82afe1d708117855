#pragma once

#include <memory>
#include <string>

#include "client/cli/common/progress.h"

namespace dcloc::cli {

/// The progress of work in many named runs, under the name of the run at hand.
class CampaignProgress {
 public:
  /// `share` is of the whole work.
  void Update(const std::string& run_name, double share) {
    if (progress_ == nullptr || run_name != run_name_) {
      progress_.reset();  // wipes its line
      progress_ = std::make_unique<Progress>(run_name);
      run_name_ = run_name;
    }
    progress_->UpdateShare(share);
  }

 private:
  std::string run_name_;
  std::unique_ptr<Progress> progress_;
};

}  // namespace dcloc::cli
