#include "ui/gui_command.h"

#include "ui/gui_arguments.h"
#include "ui/gui_window.h"

#include <QApplication>
#include <cstdlib>
#include <exception>
#include <iostream>

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

}  // namespace

int RunGui(int argc, char** argv) {
  GuiArguments arguments;
  try {
    if (!ParseGuiArguments(argc, argv, &arguments)) {
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

  GuiWindow window(arguments.manager, &arguments.options);
  window.Show(arguments.import_path);
  return app.exec();
}

void InitializeGuiResources() { InitializeResources(); }

}  // namespace structnerf
