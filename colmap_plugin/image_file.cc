#include "colmap_plugin/image_file.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <string>
#include <string_view>

#include <opencv2/imgcodecs.hpp>

namespace structnerf {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kPngBegin = "\x89PNG\r\n\x1a\n"sv;
constexpr std::string_view kPngEnd = "IEND\xae\x42\x60\x82"sv;
constexpr std::string_view kJpegBegin = "\xff\xd8\xff"sv;
constexpr std::string_view kJpegEnd = "\xff\xd9"sv;

// At most so many bytes from an offset on.
std::string Read(std::ifstream* file, const size_t offset, const size_t size) {
  std::string bytes(size, '\0');
  file->clear();
  file->seekg(static_cast<std::streamoff>(offset));
  file->read(bytes.data(), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<size_t>(file->gcount()));
  return bytes;
}

// Where the scan of a JPEG begins, after all segments that may hold images of
// their own (thumbnails); npos if that is missing.
size_t FindScan(const std::string_view jpeg) {
  constexpr unsigned char kStartOfScan = 0xda;
  const auto byte = [&](const size_t i) {
    return static_cast<unsigned char>(jpeg[i]);
  };
  size_t i = 2;
  while (i + 4 <= jpeg.size()) {
    if (byte(i) != 0xff || byte(i + 1) == 0xff) {
      ++i;  // fill bytes
    } else if (byte(i + 1) == kStartOfScan) {
      return i;
    } else {
      i += 2 + (size_t{byte(i + 2)} << 8) + byte(i + 3);
    }
  }
  return std::string_view::npos;
}

}  // namespace

cv::Mat3b ReadColorImage(const std::string& path) {
  return cv::imread(path, cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION);
}

cv::Mat1b ReadGreyImage(const std::string& path) {
  return cv::imread(path, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
}

bool IsCutOff(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string begin = Read(&file, 0, kPngBegin.size());
  const bool is_png = begin == kPngBegin;
  if (!is_png && begin.substr(0, kJpegBegin.size()) != kJpegBegin) {
    return false;
  }
  const std::string_view end = is_png ? kPngEnd : kJpegEnd;
  file.seekg(0, std::ios::end);
  const size_t size = static_cast<size_t>(file.tellg());
  if (Read(&file, size - std::min(size, end.size()), end.size()) == end) {
    return false;
  }
  // Cameras append things of their own.
  const std::string bytes = Read(&file, 0, size);
  const size_t first = is_png ? 0 : FindScan(bytes);
  return first == std::string::npos ||
         bytes.find(end, first) == std::string::npos;
}

}  // namespace structnerf
