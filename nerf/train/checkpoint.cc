#include "nerf/train/checkpoint.h"

#include "nerf/util/checksummed_file.h"

#include <filesystem>
#include <memory>
#include <vector>

namespace structnerf {
namespace {

namespace fs = std::filesystem;

constexpr FileFormat kFormat = {
    {'S', 'N', 'C', 'H', 'E', 'C', 'K', '\0'}, /*version=*/4, "checkpoint"};

constexpr char kNewestName[] = "checkpoint.bin";
constexpr char kOlderName[] = "checkpoint.older.bin";

// Differences that a message lists.
constexpr int kMaxDifferences = 3;

void WriteRun(const std::map<std::string, std::string>& run,
              StateWriter* writer) {
  writer->WriteValue(static_cast<uint64_t>(run.size()));
  for (const auto& [name, value] : run) {
    writer->WriteArray(name);
    writer->WriteArray(value);
  }
}

std::map<std::string, std::string> ReadRun(StateReader* reader) {
  std::map<std::string, std::string> run;
  const auto size = reader->ReadValue<uint64_t>();
  for (uint64_t i = 0; i < size; ++i) {
    const auto name = reader->ReadArray<std::string>();
    run[name] = reader->ReadArray<std::string>();
  }
  return run;
}

// Nothing is an empty one.
void WriteMatchedDepth(const MatchedDepth* depth, StateWriter* writer) {
  writer->WriteValue(static_cast<uint64_t>(depth ? depth->size() : 0));
  if (depth != nullptr) {
    for (const std::vector<float>& view : *depth) {
      writer->WriteArray(view);
    }
  }
}

std::shared_ptr<const MatchedDepth> ReadMatchedDepth(StateReader* reader) {
  const auto num_views = reader->ReadValue<uint64_t>();
  if (num_views == 0) {
    return nullptr;
  }
  const auto depth = std::make_shared<MatchedDepth>();
  for (uint64_t i = 0; i < num_views; ++i) {
    depth->push_back(reader->ReadArray<std::vector<float>>());
  }
  return depth;
}

void WriteState(const TrainingState& state, StateWriter* writer) {
  writer->WriteValue(state.step);
  writer->WriteValue(state.is_complete);
  writer->WriteValue(state.mean_loss);
  writer->WriteValue(state.held_out_psnr);
  writer->WriteValue(state.next_psnr);
  state.convergence.SaveState(writer);
  const TrainingSummary& summary = state.summary;
  writer->WriteValue(summary.num_steps);
  writer->WriteValue(summary.stopped_early);
  writer->WriteValue(summary.num_steps_to_converge);
  writer->WriteValue(summary.seconds);
  writer->WriteValue(summary.confirmed_share);
  WriteMatchedDepth(state.matched_depth.get(), writer);
  writer->WriteArray(state.first_round.grid);
  writer->WriteArray(state.first_round.network);
}

TrainingState ReadState(StateReader* reader) {
  TrainingState state;
  state.step = reader->ReadValue<int>();
  state.is_complete = reader->ReadValue<uint8_t>() != 0;
  state.mean_loss = reader->ReadValue<double>();
  state.held_out_psnr = reader->ReadValue<double>();
  state.next_psnr = reader->ReadValue<double>();
  state.convergence.LoadState(reader);
  TrainingSummary& summary = state.summary;
  summary.num_steps = reader->ReadValue<int>();
  summary.stopped_early = reader->ReadValue<uint8_t>() != 0;
  summary.num_steps_to_converge = reader->ReadValue<int>();
  summary.seconds = reader->ReadValue<double>();
  summary.confirmed_share = reader->ReadValue<double>();
  state.matched_depth = ReadMatchedDepth(reader);
  state.first_round.grid = reader->ReadArray<std::vector<float>>();
  state.first_round.network = reader->ReadArray<std::vector<float>>();
  return state;
}

// Throws CheckpointMismatch if a value of `wanted` is another one in `found`.
void CheckRun(const std::map<std::string, std::string>& wanted,
              const std::map<std::string, std::string>& found) {
  std::string differences;
  int num_differences = 0;
  for (const auto& [name, value] : wanted) {
    const auto it = found.find(name);
    const std::string found_value = it == found.end() ? "none" : it->second;
    if (found_value != value && ++num_differences <= kMaxDifferences) {
      differences += (differences.empty() ? "" : ", ") + name + " is " +
                     found_value + " there and " + value + " now";
    }
  }
  if (num_differences > 0) {
    throw CheckpointMismatch("the checkpoint belongs to another run: " +
                             differences);
  }
}

struct OpenCheckpoint {
  std::unique_ptr<ChecksummedFileReader> reader;  // before the engine's state
  TrainingState state;
  std::string warning;
};

// Opens the newest checkpoint that is intact; null if there is none.
OpenCheckpoint Open(const CheckpointOptions& options) {
  OpenCheckpoint checkpoint;
  std::string other_version;
  for (const char* name : {kNewestName, kOlderName}) {
    const fs::path path = fs::path(options.folder) / name;
    if (!fs::exists(path)) {
      continue;
    }
    try {
      checkpoint.reader =
          std::make_unique<ChecksummedFileReader>(kFormat, path.string());
    } catch (const OtherFormatVersion& error) {
      other_version = error.what();
      continue;
    } catch (const std::runtime_error& error) {
      checkpoint.warning +=
          (checkpoint.warning.empty() ? "" : "; ") + std::string(error.what());
      continue;
    }
    CheckRun(options.run, ReadRun(checkpoint.reader.get()));
    checkpoint.state = ReadState(checkpoint.reader.get());
    return checkpoint;
  }
  if (!other_version.empty()) {
    throw CheckpointMismatch(other_version);
  }
  return checkpoint;
}

template <typename T>
void AddArray(const std::vector<T>& values, Checksum* checksum) {
  checksum->Add(values.data(), values.size() * sizeof(T));
}

// What the scene is told from others by.
std::map<std::string, std::string> DescribeScene(const Scene& scene) {
  Checksum cameras;
  Checksum photographs;
  Checksum masks;
  Checksum priors;
  for (const View& view : scene.views) {
    AddArray(std::vector<char>(view.name.begin(), view.name.end()), &cameras);
    cameras.Add(&view.camera.width, sizeof(int));
    cameras.Add(&view.camera.height, sizeof(int));
    for (const double value :
         {view.camera.fx, view.camera.fy, view.camera.cx, view.camera.cy}) {
      cameras.Add(&value, sizeof(value));
    }
    cameras.Add(view.cam_from_world_rotation.data(), 9 * sizeof(double));
    cameras.Add(view.cam_from_world_translation.data(), 3 * sizeof(double));
    AddArray(view.image.data, &photographs);
    photographs.Add(view.exposure.gain.data(), 3 * sizeof(float));
    photographs.Add(view.exposure.offset.data(), 3 * sizeof(float));
    AddArray(view.segments, &photographs);
    AddArray(view.mask, &masks);
    AddArray(view.prior_depth, &priors);
    AddArray(view.prior_deviation, &priors);
    AddArray(view.near_depth, &priors);
    AddArray(view.far_depth, &priors);
  }
  Checksum points;
  for (const SparsePoint& point : scene.points) {
    points.Add(point.xyz.data(), 3 * sizeof(double));
    points.Add(&point.error, sizeof(point.error));
    for (const Observation& observation : point.track) {
      points.Add(&observation.view_idx, sizeof(int));
      points.Add(observation.xy.data(), 2 * sizeof(double));
    }
  }
  return {{"number of images", std::to_string(scene.views.size())},
          {"number of sparse points", std::to_string(scene.points.size())},
          {"checksum of the cameras and poses", cameras.Text()},
          {"checksum of the photographs", photographs.Text()},
          {"checksum of the masks", masks.Text()},
          {"checksum of the depth priors", priors.Text()},
          {"checksum of the sparse points", points.Text()}};
}

}  // namespace

bool HasCheckpoint(const std::string& folder) {
  return fs::exists(fs::path(folder) / kNewestName) ||
         fs::exists(fs::path(folder) / kOlderName);
}

CheckpointInfo FindCheckpoint(const CheckpointOptions& options) {
  const OpenCheckpoint checkpoint = Open(options);
  CheckpointInfo info;
  info.warning = checkpoint.warning;
  if (checkpoint.reader != nullptr) {
    info.num_steps = checkpoint.state.step;
    info.is_complete = checkpoint.state.is_complete;
  }
  return info;
}

Checkpoints::Checkpoints(const CheckpointOptions& options, const Scene& scene)
    : options_(options), last_save_(std::chrono::steady_clock::now()) {
  if (IsEnabled()) {
    options_.run.merge(DescribeScene(scene));
  }
}

bool Checkpoints::Load(RenderEngine* engine,
                       TrainingGuards* guards,
                       TrainingState* state) const {
  if (!IsEnabled()) {
    return false;
  }
  const OpenCheckpoint checkpoint = Open(options_);
  if (checkpoint.reader == nullptr) {
    return false;
  }
  guards->LoadState(checkpoint.reader.get());
  engine->LoadState(checkpoint.reader.get());
  *state = checkpoint.state;
  return true;
}

void Checkpoints::Save(const RenderEngine& engine,
                       const TrainingGuards& guards,
                       const TrainingState& state) {
  if (!IsEnabled() || options_.interval_seconds <= 0) {
    return;
  }
  const fs::path folder(options_.folder);
  ChecksummedFileWriter writer(kFormat, (folder / kNewestName).string());
  WriteRun(options_.run, &writer);
  WriteState(state, &writer);
  guards.SaveState(&writer);
  engine.SaveState(&writer);
  writer.Commit((folder / kOlderName).string());
  last_save_ = std::chrono::steady_clock::now();
}

void Checkpoints::SaveIfDue(const RenderEngine& engine,
                            const TrainingGuards& guards,
                            const TrainingState& state) {
  const std::chrono::duration<double> elapsed =
      std::chrono::steady_clock::now() - last_save_;
  if (elapsed.count() >= options_.interval_seconds) {
    Save(engine, guards, state);
  }
}

}  // namespace structnerf
