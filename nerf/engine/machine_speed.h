#pragma once

namespace structnerf {

// Wall time that a fixed piece of rendering takes now on `num_threads` threads
// (-1 = all cores), divided by what it took on as many free cores of the server
// of 2023 that times are estimated for. Takes a fraction of a second. What else
// the machine has to do counts, too.
double MeasureSlowness(int num_threads);

}  // namespace structnerf
