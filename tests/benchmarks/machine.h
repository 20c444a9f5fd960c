#pragma once

#include "nerf/field/field_layout.h"
#include "tests/benchmarks/roofline_model.h"

namespace structnerf {

// Rates of this machine with so many threads busy, for tables of a field's
// size. Measured when first asked for.
const MachineRates& MeasuredRates(const FieldLayout& layout, int num_threads);

// Prints what the probe gives for one and two threads.
void PrintMachine();

}  // namespace structnerf
