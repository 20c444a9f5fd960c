#pragma once

#include <cstddef>
#include <string>

namespace structnerf {

// Appends what printf would print, at most 511 characters.
void AppendF(std::string* text, const char* format, ...)
    __attribute__((format(printf, 2, 3)));

// The same of one number.
std::string FormatNumber(const char* format, double value);

// "640x480".
std::string SizeText(size_t width, size_t height);

// e.g. "42 s", "3:07 min", "1:02:03 h".
std::string DurationText(double seconds);

// "0.25 GB"; below 0.01 GB "0.25 MB".
std::string BytesText(size_t num_bytes);

// Written beside and renamed. Throws std::runtime_error, naming the file, if
// that fails.
void WriteTextFile(const std::string& path, const std::string& text);

}  // namespace structnerf
