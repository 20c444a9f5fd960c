#include "nerf/scene_file.h"

#include "nerf/util/checksummed_file.h"
#include "nerf/util/image_name.h"

#include <cstring>
#include <fstream>
#include <stdexcept>

namespace structnerf {
namespace {

constexpr FileFormat kFormat = {
    {'S', 'N', 'S', 'C', 'E', 'N', 'E', '\0'}, /*version=*/2, "scene"};

template <typename Vector>
void WriteVector(const Vector& vector, StateWriter* writer) {
  writer->Write(vector.data(), vector.size() * sizeof(*vector.data()));
}

template <typename Vector>
void ReadVector(StateReader* reader, Vector* vector) {
  reader->Read(vector->data(), vector->size() * sizeof(*vector->data()));
}

void WriteView(const View& view, StateWriter* writer) {
  writer->WriteArray(view.name);
  const PinholeCamera& camera = view.camera;
  writer->WriteValue(static_cast<int32_t>(camera.width));
  writer->WriteValue(static_cast<int32_t>(camera.height));
  WriteVector(Eigen::Vector4d(camera.fx, camera.fy, camera.cx, camera.cy),
              writer);
  // Eigen stores columns.
  WriteVector(Eigen::Matrix3d(view.cam_from_world_rotation.transpose()),
              writer);
  WriteVector(view.cam_from_world_translation, writer);
  writer->WriteValue(static_cast<int32_t>(view.image.width));
  writer->WriteValue(static_cast<int32_t>(view.image.height));
  writer->WriteArray(view.image.data);
  WriteVector(view.exposure.gain, writer);
  WriteVector(view.exposure.offset, writer);
  writer->WriteArray(view.mask);
  writer->WriteArray(view.segments);
  writer->WriteArray(view.prior_depth);
  writer->WriteArray(view.prior_deviation);
  writer->WriteArray(view.near_depth);
  writer->WriteArray(view.far_depth);
}

View ReadView(StateReader* reader) {
  View view;
  view.name = reader->ReadArray<std::string>();
  PinholeCamera& camera = view.camera;
  camera.width = reader->ReadValue<int32_t>();
  camera.height = reader->ReadValue<int32_t>();
  for (double* parameter : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) {
    *parameter = reader->ReadValue<double>();
  }
  ReadVector(reader, &view.cam_from_world_rotation);
  view.cam_from_world_rotation.transposeInPlace();
  ReadVector(reader, &view.cam_from_world_translation);
  view.image.width = reader->ReadValue<int32_t>();
  view.image.height = reader->ReadValue<int32_t>();
  view.image.data = reader->ReadArray<std::vector<uint8_t>>();
  ReadVector(reader, &view.exposure.gain);
  ReadVector(reader, &view.exposure.offset);
  view.mask = reader->ReadArray<std::vector<uint8_t>>();
  view.segments = reader->ReadArray<std::vector<int32_t>>();
  view.prior_depth = reader->ReadArray<std::vector<float>>();
  view.prior_deviation = reader->ReadArray<std::vector<float>>();
  view.near_depth = reader->ReadArray<std::vector<float>>();
  view.far_depth = reader->ReadArray<std::vector<float>>();
  return view;
}

void WritePoint(const SparsePoint& point, StateWriter* writer) {
  WriteVector(point.xyz, writer);
  writer->WriteValue(point.error);
  writer->WriteValue(static_cast<uint64_t>(point.track.size()));
  for (const Observation& observation : point.track) {
    writer->WriteValue(static_cast<int32_t>(observation.view_idx));
    WriteVector(observation.xy, writer);
  }
}

SparsePoint ReadPoint(StateReader* reader) {
  SparsePoint point;
  ReadVector(reader, &point.xyz);
  point.error = reader->ReadValue<double>();
  const auto num_observations = reader->ReadValue<uint64_t>();
  // Not reserved: a wrong number ends the file, not the memory.
  for (uint64_t i = 0; i < num_observations; ++i) {
    Observation& observation = point.track.emplace_back();
    observation.view_idx = reader->ReadValue<int32_t>();
    ReadVector(reader, &observation.xy);
  }
  return point;
}

}  // namespace

void WriteScene(const Scene& scene, const std::string& path) {
  ChecksummedFileWriter writer(kFormat, path);
  writer.WriteValue(static_cast<uint64_t>(scene.views.size()));
  for (const View& view : scene.views) {
    WriteView(view, &writer);
  }
  writer.WriteValue(static_cast<uint64_t>(scene.points.size()));
  for (const SparsePoint& point : scene.points) {
    WritePoint(point, &writer);
  }
  writer.Commit();
}

Scene ReadScene(const std::string& path) {
  ChecksummedFileReader reader(kFormat, path);
  Scene scene;
  try {
    const auto num_views = reader.ReadValue<uint64_t>();
    for (uint64_t i = 0; i < num_views; ++i) {
      scene.views.push_back(ReadView(&reader));
    }
    const auto num_points = reader.ReadValue<uint64_t>();
    for (uint64_t i = 0; i < num_points; ++i) {
      scene.points.push_back(ReadPoint(&reader));
    }
    if (reader.NumBytesLeft() != 0) {
      throw std::runtime_error("there are bytes behind its end");
    }
    scene.Check();
    for (const View& view : scene.views) {
      if (!IsSafeImageName(view.name)) {
        throw std::runtime_error("the name of the view \"" +
                                 Printable(view.name) +
                                 "\" would lead out of the folder of the maps");
      }
    }
  } catch (const std::exception& error) {
    throw std::runtime_error("the scene " + path +
                             " cannot be used: " + error.what());
  }
  return scene;
}

bool IsSceneFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  char magic[sizeof(kFormat.magic)] = {};
  file.read(magic, sizeof(magic));
  return file && std::memcmp(magic, kFormat.magic, sizeof(magic)) == 0;
}

}  // namespace structnerf
