#pragma once

#include "colmap_plugin/option_table.h"

#include <vector>

#include <colmap/ui/options_widget.h>

namespace structnerf {

// One row per entry of the option table that the command line has as well, with
// its help as tool tip. As all of COLMAP's option widgets, it reads the values
// when it appears and writes them when it goes.
class OptionPage : public colmap::OptionsWidget {
 public:
  OptionPage(const std::vector<OptionEntry>& entries, QWidget* parent);
};

}  // namespace structnerf
