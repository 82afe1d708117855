#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "client/cli/common/json_folder.h"
#include "client/evaluation/result_store.h"

namespace dcloc::cli {

/// What a campaign has finished, as files.
template <typename Result>
class ResultFolder final : public ResultStore<Result> {
 public:
  using FromJson = std::optional<Result> (*)(const nlohmann::json&);
  using ToJson = std::function<nlohmann::json(const Result&)>;

  ResultFolder(JsonFolder files, FromJson from_json, ToJson to_json)
      : files_(std::move(files)), from_json_(from_json), to_json_(std::move(to_json)) {}

  std::optional<Result> Load(const std::string& name) override {
    const auto json = files_.Load(name);
    return json ? from_json_(*json) : std::nullopt;
  }
  absl::Status Save(const std::string& name, const Result& result) override {
    return files_.Save(name, to_json_(result));
  }

 private:
  JsonFolder files_;
  FromJson from_json_;
  ToJson to_json_;
};

}  // namespace dcloc::cli
