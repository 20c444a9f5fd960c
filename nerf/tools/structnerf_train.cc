#include "nerf/engine/devices.h"
#include "nerf/scene_file.h"
#include "nerf/tools/maps_folder.h"
#include "nerf/tools/train_arguments.h"
#include "nerf/util/interrupts.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

namespace structnerf {
namespace {

// Plain lines on standard error, at every tenth of a stage. The first Ctrl-C
// ends training early, the second everything.
class LineProgress : public Progress {
 public:
  void Report(const ProgressUpdate& update) override {
    if (update.stage != stage_) {
      stage_ = update.stage;
      next_fraction_ = 0;
    }
    if (update.fraction < next_fraction_) {
      return;
    }
    next_fraction_ = update.fraction + 0.1;
    std::cerr << stage_ << ": " << static_cast<int>(100 * update.fraction)
              << " %";
    if (update.seconds_left >= 0) {
      std::cerr << ", " << static_cast<int>(update.seconds_left) << " s left";
    }
    std::cerr << std::endl;
  }

  bool ShouldStop() override { return ScopedInterrupts::Count() >= 1; }
  bool ShouldAbort() override { return ScopedInterrupts::Count() >= 2; }

 private:
  std::string stage_;
  double next_fraction_ = 0;
};

void PrintSummary(const MapsSummary& summary, const TrainArguments& arguments) {
  const TrainingSummary& training = summary.training;
  const double seconds = std::max(training.seconds, 1e-9);
  const double percent = 100.0 / static_cast<double>(summary.num_pixels);
  std::printf("Device:    %s\n", arguments.device.c_str());
  std::printf("Training:  %d steps in %.2f s (%.0f rays/s, %.0f samples/s)\n",
              training.num_steps,
              training.seconds,
              training.num_rays / seconds,
              training.num_samples / seconds);
  std::printf("Maps:      %.2f s\n", summary.map_seconds);
  std::printf("Pixels:    %.1f %% have depth, %.1f %% confirmed depth\n",
              percent * summary.num_photometric,
              percent * summary.num_geometric);
  std::printf("Loss:      %.5f\n", training.final_loss);
  for (const auto& [name, count] : training.guard_counts) {
    if (count > 0) {
      std::printf("Guard:     %s %d\n", name.c_str(), count);
    }
  }
  std::printf("Written:   %s\n", arguments.output_path.c_str());
}

int Run(const std::vector<std::string>& words) {
  if (words.empty() || words[0] == "-h" || words[0] == "--help") {
    std::cout << TrainUsage();
    return words.empty() ? EXIT_FAILURE : EXIT_SUCCESS;
  }
  const TrainArguments arguments = ParseTrainArguments(words);
  const ScopedInterrupts interrupts;
  LineProgress progress;
  const auto warn = [](const std::string& warning) {
    std::cerr << "WARNING: " << warning << std::endl;
  };
  const MapsSummary summary =
      ReconstructIntoFolder(ReadScene(arguments.scene_path),
                            arguments.options,
                            EnginesOfDevice(arguments.device, warn),
                            arguments.output_path,
                            warn,
                            &progress);
  PrintSummary(summary, arguments);
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace structnerf

int main(int argc, char** argv) {
  try {
    return structnerf::Run({argv + 1, argv + argc});
  } catch (const structnerf::Aborted&) {
    std::cerr << "ERROR: Quit before the end; nothing was written."
              << std::endl;
  } catch (const std::exception& error) {
    std::cerr << "ERROR: " << error.what() << std::endl;
  }
  return EXIT_FAILURE;
}
