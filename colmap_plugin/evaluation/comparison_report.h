#pragma once

#include "colmap_plugin/evaluation/comparison.h"

#include <array>
#include <string>
#include <vector>

namespace structnerf {

// Everything but the pictures, machine-readable; metres, seconds and shares in
// [0, 1]. What is not known is null or missing.
std::string ComparisonJson(const Comparison& comparison);

// A table for people.
std::string ComparisonText(const Comparison& comparison);

// One page with numbers and pictures that needs no other file.
std::string ComparisonHtml(const Comparison& comparison);

// Writes comparison.json and comparison.html into a folder, which is created if
// missing. Returns the path of the page. Throws std::runtime_error, naming the
// file, if one cannot be written.
std::string WriteComparison(const Comparison& comparison,
                            const std::string& folder);

// The rows of table and page.
struct ComparisonRow {
  std::string name;
  std::array<std::string, 2> values;
};
std::vector<ComparisonRow> ComparisonRows(const Comparison& comparison);

// How well the maps agree, for instance "of the pixels where both have depth,
// 80.1 % agree within 1 %, ...".
std::string AgreementText(const MapAgreement& agreement);

}  // namespace structnerf
