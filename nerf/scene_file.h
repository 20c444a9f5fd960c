#pragma once

#include "nerf/scene.h"

#include <string>

namespace structnerf {

// A scene in one file, for machines without COLMAP and for reports of faults:
// "SNSCENE\0" and the version of the format; the number of views (64 bits) and
// of each
//
//   name                      number of bytes (64 bits), bytes
//   camera                    width, height (32-bit integers); fx, fy, cx, cy
//   pose                      rotation row after row, translation
//   image                     width, height; RGB bytes
//   exposure                  gain and offset of R, G and B, 32-bit floats
//   mask, segments            bytes; 32-bit integers
//   prior depth, deviation    32-bit floats
//   near depth, far depth     32-bit floats
//
// then the number of points and of each its position, its error, and its track:
// the view (32 bits), x and y of every observation. Real numbers are 64 bits
// where nothing else is said; arrays have their length (64 bits) in front and
// mean what they do in nerf/scene.h. A checksum ends the file
// (nerf/util/checksummed_file.h).

// Writes beside the name and renames. Throws std::runtime_error, naming the
// file, if the disk is full or cannot be written.
void WriteScene(const Scene& scene, const std::string& path);

// Throws std::runtime_error, naming the file and what is wrong, if it cannot be
// read, is damaged, of another format or version, if Scene::Check() refuses
// what it holds, or a name is not one of a file below a folder.
Scene ReadScene(const std::string& path);

// Whether there is a file that begins as one, damaged or not, of whatever
// version.
bool IsSceneFile(const std::string& path);

}  // namespace structnerf
