#pragma once

#include <functional>
#include <string>
#include <vector>

namespace structnerf {

// One extreme that the method must take.
struct StabilityCase {
  std::string name;

  // Returns what was measured. Throws UnstableError if that is not acceptable.
  std::function<std::string()> run;

  // Part of the ending of the one sentence with which the program must refuse
  // the case; empty = it must give a finite result.
  std::string refusal = {};

  // It may also give a finite result, as luck will have it.
  bool is_refusal_optional = false;

  // Too slow for every build.
  bool is_slow = false;
};

// What a case found wrong.
struct UnstableError {
  std::string text;
};

// Throws UnstableError unless the condition holds.
void RequireStable(bool condition, const std::string& text);

// "1.2e-05".
std::string ShortNumber(double value);

// Runs every case, prints one line for each (state, name, what was measured or
// the text of the refusal), and returns how many failed.
int RunStabilityCases(const std::vector<StabilityCase>& cases);

// The cases by subject; those of the program only where it is built.
std::vector<StabilityCase> SceneFrameCases();      // scale, offset, rotation
std::vector<StabilityCase> CameraCases();          // lenses, numbers, baselines
std::vector<StabilityCase> ImageCases();           // sizes, plain pixels
std::vector<StabilityCase> SparseModelCases();     // outliers, errors, gaps
std::vector<StabilityCase> KernelCases();          // overflow and underflow
std::vector<StabilityCase> GradientKernelCases();  // as above, backward
std::vector<StabilityCase> StereoCases();          // matching of windows
std::vector<StabilityCase> LossCases();            // float against double
std::vector<StabilityCase> DepthLossCases();       // as above, of single rays
std::vector<StabilityCase> ObjectiveCases();       // as above, of a tile
std::vector<StabilityCase> ProgramCases();         // image files
std::vector<StabilityCase> TrainingCases();        // rates and schedules

}  // namespace structnerf
