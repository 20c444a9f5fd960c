#pragma once

#include <functional>
#include <string>
#include <vector>

namespace structnerf {

struct Command {
  std::string name;
  std::string help;  // one line

  // As in COLMAP: `argv[0]` is the program, the options follow.
  std::function<int(int argc, char** argv)> run;
};

// The commands that this program adds to COLMAP's.
const std::vector<Command>& Commands();

// Depth and normal maps and a fused cloud from a sparse model.
int RunStructNerfDense(int argc, char** argv);

// Whether the dense stage takes these options; says what is wrong, or throws
// std::runtime_error with it, if not.
bool AreDenseOptions(const std::vector<std::string>& options);

// Depth, cloud and rendered images of a workspace against ground truth.
int RunStructNerfEval(int argc, char** argv);

// Two workspaces side by side, as one HTML page.
int RunStructNerfCompare(int argc, char** argv);

// New views of a trained field (colmap_plugin/rendering).
int RunStructNerfRender(int argc, char** argv);

// Runs the dense stage with several settings and compares time and error
// (colmap_plugin/tradeoff).
int RunStructNerfTradeoff(int argc, char** argv);

// The stock program's help with that of these commands appended.
int RunHelp(const std::vector<Command>& commands);

int RunVersion();

}  // namespace structnerf
