// Drives the method to its extremes and prints what comes of each.
//   structnerf_stability [--full] [WORD]
// --full adds the slow cases; WORD keeps those whose name contains it.

#include "tests/stability/stability_case.h"

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

int main(int argc, char** argv) {
  bool is_full = false;
  std::string word;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--full") {
      is_full = true;
    } else if (argument.empty() || argument[0] == '-' || !word.empty()) {
      std::fprintf(stderr, "usage: structnerf_stability [--full] [WORD]\n");
      return EXIT_FAILURE;
    } else {
      word = argument;
    }
  }
  std::vector<structnerf::StabilityCase> chosen;
  for (const auto& cases : {structnerf::SceneFrameCases(),
                            structnerf::CameraCases(),
                            structnerf::ImageCases(),
                            structnerf::SparseModelCases(),
                            structnerf::KernelCases(),
                            structnerf::GradientKernelCases(),
                            structnerf::StereoCases(),
                            structnerf::LossCases(),
                            structnerf::DepthLossCases(),
                            structnerf::ObjectiveCases(),
                            structnerf::TrainingCases(),
#ifdef STRUCTNERF_PROGRAM
                            structnerf::ProgramCases()
#endif
       }) {
    for (const structnerf::StabilityCase& stability_case : cases) {
      if ((is_full || !stability_case.is_slow) &&
          stability_case.name.find(word) != std::string::npos) {
        chosen.push_back(stability_case);
      }
    }
  }
  const int num_failed = structnerf::RunStabilityCases(chosen);
  std::printf("%zu cases, %d failed\n", chosen.size(), num_failed);
  return num_failed == 0 && !chosen.empty() ? EXIT_SUCCESS : EXIT_FAILURE;
}
