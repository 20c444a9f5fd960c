#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

// What a fuzz program is about: takes any bytes and must neither crash nor
// throw nor do harm. Called by libFuzzer, or by mutation_main.cc where there is
// none.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

namespace structnerf {

// Well-formed inputs to start from.
std::vector<std::string> FuzzSeeds();

// Ends the program with the text: the input has shown a fault.
[[noreturn]] void FuzzFault(const std::string& text);

// Writes the bytes to the file, which replaces what there was.
void WriteFuzzFile(const std::string& path, const uint8_t* data, size_t size);

// The content of a file.
std::string ReadFuzzFile(const std::string& path);

}  // namespace structnerf
