#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/evaluation/paper/study.h"

namespace dcloc::paper {

/// All tables of the study as numbers, the paper's among them.
nlohmann::ordered_json StudyJson(std::span<const RunResult> results);

/// The study as a self-contained page: a summary, then table by table and figure by figure, the
/// paper's numbers beside ours. Each figure is also written into `folder` as a PNG file. Errors as
/// of gnuplot's pictures.
absl::StatusOr<std::string> StudyHtml(
    std::span<const RunResult> results,
    const std::vector<std::pair<std::string, std::string>>& settings,
    const std::filesystem::path& folder);

}  // namespace dcloc::paper
