// The arguments of structnerf_train, one a line: what is accepted is in the
// ranges that the options have.

#include "nerf/method_options.h"
#include "nerf/tools/train_arguments.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/option_ranges.h"

#include <sstream>
#include <stdexcept>

namespace structnerf {

std::vector<std::string> FuzzSeeds() {
  const std::string paths = "--scene_path\na\n--output_path=b\n";
  return {paths + "--StructNeRF.quality=high\n--StructNeRF.num_steps\n5",
          paths + "--StructNeRF.method=dsnerf\n--StructNeRF.patch_weight=0.1",
          paths + "--StructNeRF.sparse_form=kl\n--StructNeRF.test_every\n1",
          paths +
              "--StructNeRF.max_resolution=-1\n"
              "--StructNeRF.grid_learning_rate=1e-2\n"
              "--StructNeRF.stop_when_converged=1"};
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  std::istringstream lines(
      std::string(reinterpret_cast<const char*>(data), size));
  std::vector<std::string> arguments;
  for (std::string line; std::getline(lines, line);) {
    arguments.push_back(line);
  }
  try {
    TrainArguments parsed = ParseTrainArguments(arguments);
    RequireOptionsInRange(MakeMethodOptionEntries(&parsed.options));
    if (parsed.scene_path.empty() || parsed.output_path.empty()) {
      FuzzFault("a path is missing");
    }
  } catch (const std::invalid_argument& error) {
    if (std::string(error.what()).empty()) {
      FuzzFault("an argument is refused without a word");
    }
  }
  return 0;
}
