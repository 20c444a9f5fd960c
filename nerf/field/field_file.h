#pragma once

#include "nerf/field/field_layout.h"
#include "nerf/options.h"

#include <string>

#include <Eigen/Core>

namespace structnerf {

// A trained field on disk: a magic word, a format version, the shape (options
// and box extent), the parameters in full precision and a checksum over all of
// it.

// Written beside and renamed. Throws std::runtime_error, naming the file, if
// that fails.
void WriteField(const std::string& path,
                const FieldOptions& options,
                const Eigen::Vector3f& extent,
                const FieldParameters& parameters);

// Throws std::runtime_error, naming the file and what is wrong, if it cannot be
// read, is damaged, or holds a field of another shape.
FieldParameters ReadField(const std::string& path,
                          const FieldOptions& options,
                          const Eigen::Vector3f& extent);

}  // namespace structnerf
