#pragma once

#include <string>

#include <opencv2/core.hpp>

namespace structnerf {

// Writes an image as PNG beside its name and renames it. Throws
// std::runtime_error, naming the file, if the disk is full or it cannot be
// written.
void WritePng(const std::string& path, const cv::Mat& image);

}  // namespace structnerf
