#include "nerf/progress.h"

namespace structnerf {

void Progress::Report(const ProgressUpdate&) {}

bool Progress::ShouldStop() { return false; }

bool Progress::ShouldAbort() { return false; }

}  // namespace structnerf
