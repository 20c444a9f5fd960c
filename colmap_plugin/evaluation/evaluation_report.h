#pragma once

#include "colmap_plugin/evaluation/evaluator.h"

#include <string>

namespace structnerf {

// Everything that was measured, machine-readable; metres, decibels and shares
// in [0, 1]. What was not measured is null or missing.
std::string EvaluationJson(const Evaluation& evaluation);

// Tables for people.
std::string EvaluationText(const Evaluation& evaluation);

}  // namespace structnerf
