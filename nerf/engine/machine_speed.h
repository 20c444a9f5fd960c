#pragma once

namespace structnerf {

// How much longer a run takes now on `num_threads` threads (-1 = all cores)
// than on as many free cores of the server of 2023 that times are estimated
// for, told from a fixed piece of rendering that takes a fraction of a second.
// What else the machine has to do counts in full. That its cores are slower
// counts as its square root: wide vectors serve rendering more than other
// stages. (A core with half as wide ones took 2.1 times as long for it, and 1.3
// times as long for whole runs.)
double MeasureSlowness(int num_threads);

}  // namespace structnerf
