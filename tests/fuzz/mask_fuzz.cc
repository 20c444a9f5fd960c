// The reader of masks, with any bytes in the file.

#include "colmap_plugin/masks.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <exception>

#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

constexpr int kWidth = 5;
constexpr int kHeight = 4;

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  std::vector<std::string> seeds;
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1}) {
    cv::Mat image(kHeight, kWidth, type);
    cv::randu(image, cv::Scalar::all(0), cv::Scalar::all(255));
    for (const char* extension : {".png", ".bmp", ".pgm"}) {
      const bool is_grey = image.channels() == 1;
      if (std::string(extension) == ".pgm" && !is_grey) {
        continue;
      }
      std::vector<uint8_t> bytes;
      cv::imencode(extension, image, bytes);
      seeds.emplace_back(bytes.begin(), bytes.end());
    }
  }
  return seeds;
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  WriteFuzzFile(MaskPath(Folder().Path().string(), "a"), data, size);
  try {
    const std::vector<uint8_t> mask =
        ReadMask(Folder().Path().string(), "a", kWidth, kHeight);
    if (mask.size() != kWidth * kHeight) {
      FuzzFault("a mask has another size than its image");
    }
    if (std::any_of(mask.begin(), mask.end(), [](const uint8_t value) {
          return value != 0 && value != 255;
        })) {
      FuzzFault("a mask is neither black nor white");
    }
  } catch (const std::exception&) {
  }
  return 0;
}
