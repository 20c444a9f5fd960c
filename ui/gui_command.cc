#include "ui/gui_command.h"

#include "colmap_plugin/colmap_compat.h"
#include "colmap_plugin/command_line.h"
#include "colmap_plugin/option_table.h"
#include "colmap_plugin/structnerf_options.h"
#include "ui/gui_window.h"

#include <QApplication>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>
#include <utility>

// The macro must not be used in a namespace.
static void InitializeResources() { Q_INIT_RESOURCE(resources); }

namespace structnerf {
namespace {

// Qt would end the process without a word to our users.
bool HasDisplay() {
#if defined(__linux__)
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"}) {
    const char* value = std::getenv(name);
    if (value != nullptr && value[0] != '\0') {
      return true;
    }
  }
  return false;
#else
  return true;
#endif
}

// Returns false if the command line is wrong, which has been said then.
bool ParseGuiOptions(const int argc,
                     char** argv,
                     colmap::OptionManager* manager,
                     StructNerfOptions* options,
                     std::string* import_path) {
  options->quality =
      FindOption({argv, argv + argc}, "StructNeRF.quality", options->quality);
  options->reconstruction = QualityPreset(options->quality);
  // From COLMAP 4.0 on, what is added here is also kept in project files.
  AddOptions(MakeOptionTable(options), manager);
  if (argc > 1) {
    manager->AddDefaultOption("import_path", import_path);
    manager->AddAllOptions();
    return ParseOptions(argc, argv, manager);
  }
  return true;
}

}  // namespace

int RunGui(int argc, char** argv) {
  StructNerfOptions options;
  colmap::OptionManager manager;
  std::string import_path;
  try {
    if (!ParseGuiOptions(argc, argv, &manager, &options, &import_path)) {
      return EXIT_FAILURE;
    }
  } catch (const std::exception& error) {
    std::cerr << "ERROR: " << error.what() << std::endl;
    return EXIT_FAILURE;
  }
  if (!HasDisplay()) {
    std::cerr << "ERROR: There is no display to open a window on; set DISPLAY, "
                 "or use the command structnerf_dense."
              << std::endl;
    return EXIT_FAILURE;
  }

  InitializeGuiResources();
#if QT_VERSION < QT_VERSION_CHECK(6, 0, 0)
  QApplication::setAttribute(Qt::AA_EnableHighDpiScaling);
  QApplication::setAttribute(Qt::AA_UseHighDpiPixmaps);
#endif
  QApplication app(argc, argv);

  GuiWindow window(std::move(manager), &options);
  window.Show();
  if (!import_path.empty()) {
    window.Window().ImportReconstruction(import_path);
  }
  return app.exec();
}

void InitializeGuiResources() { InitializeResources(); }

}  // namespace structnerf
