#pragma once

#include "colmap_plugin/evaluation/depth_truth.h"
#include "colmap_plugin/tradeoff/tradeoff_settings.h"

#include <string>

namespace structnerf {

// The scene that settings are tried on, and where.
struct TradeoffScene {
  std::string image_path;
  std::string input_path;
  std::string mask_path;    // empty = none
  std::string output_path;  // for everything that is written
  DepthTruthOptions truth;  // `path` empty = none
  std::string fingerprint;  // of model, images and masks (run_identity.h)

  // Without truth: of so many images the last is kept out of the runs, to tell
  // by it what they are worth; 0 = there are too few.
  int test_every = 0;
};

// How errors are measured.
enum class TradeoffError {
  kTruth,      // against ground truth
  kHeldOut,    // by photographs that were kept out
  kAgreement,  // by how far views agree, of which there are only two
};
TradeoffError ErrorKind(const TradeoffScene& scene);

// Writes paths in one way, fills `fingerprint` and `test_every`, and looks at
// images, masks and ground truth: it would be of no use to find that they are
// wrong after runs of hours. Throws std::runtime_error, naming the option or
// file, if one cannot be read, or if nothing can be measured against the truth.
void PrepareScene(TradeoffScene* scene);

// What one run took and gave.
struct TradeoffMeasurement {
  double seconds = 0;      // wall time of all stages
  double cpu_seconds = 0;  // of all threads
  size_t peak_bytes = 0;

  // Share of the pixels that are wrong. Against truth: of the pixels that have
  // it, in the scale of structure-from-motion; those without a depth or farther
  // off than 5 cm. By held-out photographs: of their textured pixels; those
  // that other photographs and their depth maps predict otherwise
  // (evaluation/photograph_prediction.h). By agreement: of all pixels; those
  // whose depth the other view does not confirm.
  double error = 0;

  double held_out_psnr = -1;  // dB; -1 = none
};

// Runs the dense stage as a process of its own with a seed and measures it. The
// measurement, and a picture of one depth map (TradeoffPicturePath), stay in
// the output folder; the workspace is removed. What has been measured before is
// read instead. Throws std::runtime_error if the run fails or is interrupted,
// or if what is in the output folder is of another scene.
TradeoffMeasurement MeasureSetting(const TradeoffScene& scene,
                                   const TradeoffSetting& setting,
                                   int seed);

std::string TradeoffPicturePath(const TradeoffScene& scene,
                                const TradeoffSetting& setting,
                                int seed);

}  // namespace structnerf
