#include "client/evaluation/paper/table_rows.h"

#include <utility>

#include "absl/strings/str_cat.h"

namespace dcloc::paper {
namespace {

std::string AblationLabel(const AblationRow& row) {
  const auto mark = [](bool on, const char* name) { return on ? name : "-"; };
  return absl::StrCat(mark(row.doppler, "D"), " ", mark(row.uncertainty, "U"), " ",
                      mark(row.truncation, "T"));
}

RowPlan CalibratedRow() {
  return {"dcloc, rig calibrated on other data", {.calibrated = true}, {}};
}

}  // namespace

std::string VariantName(const Variant& variant) {
  std::string name = MethodName(variant.method);
  if (!variant.doppler) name += "-nodoppler";
  if (!variant.uncertainty) name += "-nouncertainty";
  if (!variant.truncation) name += "-notruncation";
  if (variant.scans_per_submap != Variant{}.scans_per_submap) {
    absl::StrAppend(&name, "-k", variant.scans_per_submap);
  }
  if (variant.calibrated) name += "-calibrated";
  if (variant.far_prior) name += "-far";
  return name;
}

std::vector<RowPlan> Table1Rows() {
  return {{"ICP, as in the paper", {.method = MethodKind::kIcp, .doppler = false}, kIcp},
          {"NDT, as in the paper", {.method = MethodKind::kNdt, .doppler = false}, kNdt},
          {"ICP, compensated", {.method = MethodKind::kIcp}, {}},
          {"NDT, compensated", {.method = MethodKind::kNdt}, {}},
          {"MC-RANSAC", {.method = MethodKind::kMcRansac}, kMcRansac},
          {"DC-Loc", {.method = MethodKind::kDcLoc}, kDcLoc},
          {"DC-Loc++", {.method = MethodKind::kDcLocPlusPlus}, kDcLocPlusPlus},
          {"dcloc", {.method = MethodKind::kDcloc}, {}},
          CalibratedRow()};
}

std::vector<RowPlan> Table2Rows(MethodKind method) {
  std::vector<RowPlan> rows;
  rows.reserve(std::size(kTable2));
  for (const AblationRow& row : kTable2) {
    rows.push_back({AblationLabel(row),
                    {.method = method,
                     .doppler = row.doppler,
                     .uncertainty = row.uncertainty,
                     .truncation = row.truncation},
                    row.printed});
  }
  return rows;
}

std::vector<RowPlan> Table3Rows() {
  std::vector<RowPlan> rows;
  rows.reserve(std::size(kTable3));
  for (const SubmapRow& row : kTable3) {
    rows.push_back({absl::StrCat(row.scans, row.scans == 1 ? " scan" : " scans"),
                    {.scans_per_submap = row.scans},
                    row.printed});
  }
  return rows;
}

std::vector<RowPlan> NoiseRows() {
  std::vector<RowPlan> rows = {{"ICP, compensated", {.method = MethodKind::kIcp}, {}}};
  for (RowPlan& row : FigureRows()) rows.push_back(std::move(row));
  rows.push_back(CalibratedRow());
  return rows;
}

std::vector<RowPlan> FigureRows() {
  return {{"MC-RANSAC", {.method = MethodKind::kMcRansac}, {}},
          {"DC-Loc", {.method = MethodKind::kDcLoc}, {}},
          {"DC-Loc++", {.method = MethodKind::kDcLocPlusPlus}, {}},
          {"dcloc", {.method = MethodKind::kDcloc}, {}}};
}

}  // namespace dcloc::paper
