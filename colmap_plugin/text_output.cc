#include "colmap_plugin/text_output.h"

#include "nerf/util/whole_file.h"

#include <cstdarg>
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

void WriteTextFile(const std::string& path, const std::string& text) {
  WriteWholeFile(path, [&](std::ostream* stream) { *stream << text; });
}

}  // namespace structnerf
