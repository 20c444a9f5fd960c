#include "colmap_plugin/png_file.h"

#include "nerf/util/whole_file.h"

#include <cstdint>
#include <vector>

#include <opencv2/imgcodecs.hpp>

namespace structnerf {

void WritePng(const std::string& path, const cv::Mat& image) {
  // cv::imwrite does not notice if the disk is full at the end of the file.
  std::vector<uint8_t> data;
  cv::imencode(".png", image, data);
  WriteWholeFile(path, [&](std::ostream* stream) {
    stream->write(reinterpret_cast<const char*>(data.data()),
                  static_cast<std::streamsize>(data.size()));
  });
}

}  // namespace structnerf
