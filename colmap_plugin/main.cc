#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/commands.h"
#include "colmap_plugin/stock_colmap.h"

#ifdef STRUCTNERF_GUI
#include "ui/gui_command.h"
#endif

#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

// Answers our commands and hands every other one to the stock `colmap`. That
// decision comes before anything touches logging or signals, so the stock
// program starts as if it had been called itself.
int main(int argc, char** argv) {
  std::vector<structnerf::Command> commands = structnerf::Commands();
#ifdef STRUCTNERF_GUI
  commands.push_back({"gui",
                      "COLMAP's window, with StructNeRF dense reconstruction",
                      structnerf::RunGui});
#endif
  const std::string name = argc > 1 ? argv[1] : "help";
  if (name == "help" || name == "-h" || name == "--help") {
    return structnerf::RunHelp(commands);
  }
  if (name == "version" || name == "--version") {
    return structnerf::RunVersion();
  }
  for (const structnerf::Command& command : commands) {
    if (name == command.name) {
      structnerf::InitializeColmap(argv);
      argv[1] = argv[0];
      const int exit_code = command.run(argc - 1, argv + 1);
      if (exit_code != EXIT_SUCCESS) {
        // Without the ends of libraries: where memory is short, OpenBLAS' waits
        // for threads that never got theirs.
        std::cout.flush();
        std::_Exit(exit_code);
      }
      return exit_code;
    }
  }
  return structnerf::ExecStockColmap(argv);
}
