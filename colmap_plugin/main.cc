#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/commands.h"
#include "colmap_plugin/stock_colmap.h"

#include <string>

// Answers our commands and hands every other one to the stock `colmap`. That
// decision comes before anything touches logging or signals, so the stock
// program starts as if it had been called itself.
int main(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "help";
  if (name == "help" || name == "-h" || name == "--help") {
    return structnerf::RunHelp();
  }
  if (name == "version" || name == "--version") {
    return structnerf::RunVersion();
  }
  for (const structnerf::Command& command : structnerf::Commands()) {
    if (name == command.name) {
      structnerf::InitializeColmap(argv);
      argv[1] = argv[0];
      return command.run(argc - 1, argv + 1);
    }
  }
  return structnerf::ExecStockColmap(argv);
}
