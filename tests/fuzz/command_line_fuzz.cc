// The parser of the command line and of project files. Up to the first zero
// byte the input is the project file, after it arguments, one a line.

#include "colmap_plugin/command_line.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <exception>
#include <sstream>

namespace structnerf {
namespace {

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

}  // namespace

std::vector<std::string> FuzzSeeds() {
  const std::string zero(1, '\0');
  return {
      "image_path=/a\n[StructNeRF]\nnum_steps=5\nquality=low\n" + zero +
          "--image_path\n/b\n--overwrite\n--StructNeRF.quality=high",
      "log_to_stderr=false\n[Mapper]\nba_refine=1\n# comment\n[StereoFusion]\n"
      "min_num_pixels=3\n" +
          zero + "--overwrite\n1\n--StructNeRF.print_options\n-h",
      zero + "--mask_path\n--output_path=\n--\n-x\n="};
}

}  // namespace structnerf

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, const size_t size) {
  using namespace structnerf;
  const std::string input(reinterpret_cast<const char*>(data), size);
  const size_t zero = std::min(input.find('\0'), size);
  const std::string path = Folder() / "project.ini";
  WriteFuzzFile(path, data, zero);
  std::vector<std::string> args = {"structnerf_dense"};
  std::istringstream lines(input.substr(std::min(zero + 1, size)));
  for (std::string line; std::getline(lines, line);) {
    args.push_back(line);
  }
  args.push_back("--project_path=" + path);
  try {
    const std::vector<std::string> expanded =
        ExpandCommandLine(args,
                          {"image_path", "output_path", "mask_path"},
                          {"overwrite", "StructNeRF.print_options"});
    if (expanded.empty() || expanded[0] != args[0]) {
      FuzzFault("the program's name is lost");
    }
    // Expanding twice changes nothing.
    if (ExpandCommandLine(expanded, {}, {}) != expanded) {
      FuzzFault("what was expanded is not what COLMAP understands");
    }
    FindOption(expanded, "StructNeRF.quality", "medium");
  } catch (const std::exception&) {
  }
  return 0;
}
