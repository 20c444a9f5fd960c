#pragma once

namespace structnerf {

// COLMAP's window with our item in its menu. Takes the options of `colmap gui`,
// and --StructNeRF.* as what the dialog starts from.
int RunGui(int argc, char** argv);

// Icons and shaders, which COLMAP before 3.12 leaves to its main program. To be
// called once before a window is made.
void InitializeGuiResources();

}  // namespace structnerf
