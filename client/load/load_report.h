#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/evaluation/gnuplot.h"
#include "client/load/load_run.h"

namespace dcloc::load {

/// The result for scripts; latencies in ms, `shortfalls` as `Shortfalls` gives them.
nlohmann::ordered_json ToJson(const LoadResult& result, const std::vector<std::string>& shortfalls);

/// A header and a row for each result.
std::vector<std::vector<std::string>> TableOf(const std::vector<const LoadResult*>& results);

/// What happened beside latency, a line each: faults, repetitions, errors against the truth.
std::vector<std::string> NotesOf(const LoadResult& result);

/// One second as a line for people.
std::string LineOf(const LoadSecond& second);

/// Latency over time, and the rate below it.
Picture LatencyPicture(const LoadResult& result);

}  // namespace dcloc::load
