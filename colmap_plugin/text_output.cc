#include "colmap_plugin/text_output.h"

#include "colmap_plugin/memory_budget.h"
#include "nerf/util/whole_file.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>

namespace structnerf {

void AppendF(std::string* text, const char* format, ...) {
  char line[512];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(line, sizeof(line), format, arguments);
  va_end(arguments);
  *text += line;
}

std::string FormatNumber(const char* format, const double value) {
  char text[64];
  snprintf(text, sizeof(text), format, value);
  return text;
}

std::string SizeText(const size_t width, const size_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

std::string DurationText(const double seconds) {
  const int64_t rounded = std::max<int64_t>(0, std::llround(seconds));
  char text[64];
  if (rounded < 60) {
    snprintf(text, sizeof(text), "%d s", static_cast<int>(rounded));
  } else if (rounded < 3600) {
    snprintf(text,
             sizeof(text),
             "%d:%02d min",
             static_cast<int>(rounded / 60),
             static_cast<int>(rounded % 60));
  } else {
    snprintf(text,
             sizeof(text),
             "%lld:%02d:%02d h",
             static_cast<long long>(rounded / 3600),
             static_cast<int>(rounded / 60 % 60),
             static_cast<int>(rounded % 60));
  }
  return text;
}

std::string BytesText(const size_t num_bytes) {
  const double gigabytes = num_bytes / kBytesPerGb;
  return gigabytes >= 0.01 ? FormatNumber("%.2f GB", gigabytes)
                           : FormatNumber("%.2f MB", 1024 * gigabytes);
}

void WriteTextFile(const std::string& path, const std::string& text) {
  WriteWholeFile(path, [&](std::ostream* stream) { *stream << text; });
}

}  // namespace structnerf
