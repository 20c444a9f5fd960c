// The parser of the command line and of project files, and of the values of
// options. Up to the first zero byte the input is the project file, after it
// arguments, one a line.

#include "colmap_plugin/command_line.h"
#include "colmap_plugin/command_runner.h"
#include "colmap_plugin/option_table.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/option_ranges.h"
#include "tests/support/temp_dir.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <exception>
#include <sstream>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

namespace structnerf {
namespace {

const TempDir& Folder() {
  static const TempDir folder;
  return folder;
}

// As structnerf_dense does with what was expanded.
void ParseValues(const std::vector<std::string>& args) {
  StructNerfOptions options;
  std::string path;
  const std::vector<OptionEntry> table = MakeOptionTable(&options);
  colmap::OptionManager manager;
  for (const char* name : {"image_path", "output_path", "mask_path"}) {
    manager.AddDefaultOption(name, &path, "");
  }
  manager.AddDefaultOption("overwrite", &options.overwrite, "");
  AddOptions(table, &manager);
  manager.AddStereoFusionOptions();
  if (!ParseArguments(args, &manager)) {
    return;
  }
  try {
    CheckOptions(options);
  } catch (const std::runtime_error&) {
    return;
  }
  RequireOptionsInRange(table);
}

// COLMAP ends the process (before 3.13) over what it does not understand, so
// that takes a process of its own.
void ParseValuesApart(const std::vector<std::string>& args) {
  const pid_t child = fork();
  if (child == 0) {
    // Without what the parent still needs at its end.
    std::atexit([] { _exit(EXIT_SUCCESS); });
    dup2(open("/dev/null", O_WRONLY), STDOUT_FILENO);
    dup2(open("/dev/null", O_WRONLY), STDERR_FILENO);
    ParseValues(args);
    _exit(EXIT_SUCCESS);
  }
  int status = 0;
  pid_t ended = -1;
  do {
    ended = waitpid(child, &status, 0);
  } while (ended < 0 && errno == EINTR);  // libFuzzer's timer
  if (child < 0 || ended != child) {
    FuzzFault("the test's own process cannot be made");
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != EXIT_SUCCESS) {
    FuzzFault("the values of options end the program with status " +
              std::to_string(status));
  }
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
      zero + "--mask_path\n--output_path=\n--\n-x\n=",
      "[StructNeRF]\nmax_minutes=0.5\ninput_type=photometric\n" + zero +
          "--StructNeRF.patch_weight\n1e-2\n--StructNeRF.num_threads=2\n"
          "--StructNeRF.resume=1\n--StereoFusion.max_reproj_error=1.5"};
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
                          {"StructNeRF.", "image_path", "mask_path"},
                          {"overwrite", "StructNeRF.print_options"});
    if (expanded.empty() || expanded[0] != args[0]) {
      FuzzFault("the program's name is lost");
    }
    // Expanding twice changes nothing.
    if (ExpandCommandLine(expanded, {}, {}) != expanded) {
      FuzzFault("what was expanded is not what COLMAP understands");
    }
    FindOption(expanded, "StructNeRF.quality", "medium");
    ParseValuesApart(expanded);
  } catch (const std::exception&) {
  }
  return 0;
}
