#pragma once

#include "nerf/progress.h"

#include <string>

namespace structnerf {

// Progress of a whole run, which also has something to say now and then. The
// default implementation writes it to COLMAP's log, which its user interface
// shows.
class RunProgress : public Progress {
 public:
  // One sentence about a decision that was taken for the user.
  virtual void Note(const std::string& sentence);

  // One sentence about something that may spoil the result.
  virtual void Warn(const std::string& sentence);

  // Name of the image whose view somebody wants to watch during training; empty
  // = none. Asked often.
  virtual std::string PreviewImage();
};

}  // namespace structnerf
